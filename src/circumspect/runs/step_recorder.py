"""Recording of the answers of a run."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.reconstruction import ObjectModel
from circumspect.recording import RunRecorder


class StepRecorder:
    """Records the answer after each frame and closes the recording; a `PipelineObserver`."""

    def __init__(self, recorder: RunRecorder) -> None:
        self._recorder = recorder

    def on_step(self, step: RecognitionStep) -> None:
        """Record the answer so far and the pose of the odometry frame."""
        T_map_odom = None if step.pose is None else step.pose.T_map_odom
        self._recorder.answer(step.stamp, step.prediction, _extent(step.model), T_map_odom)

    def on_end(self, result: RecognitionResult) -> None:
        """Record the final answer and close the recording."""
        if (last := result.last) is not None:
            self._recorder.answer(last.stamp, last.prediction, _extent(last.model), None)
        self._recorder.close()


def _extent(model: ObjectModel) -> NDArray[np.float64] | None:
    """(2, 3) lowest and highest corner [m]; None before the first points."""
    try:
        points = model.preview.cloud().points_xyz
    except GeometryError:
        return None
    return np.stack([points.min(axis=0), points.max(axis=0)])
