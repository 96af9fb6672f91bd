"""Answers into the recording of a run."""

from __future__ import annotations

import numpy as np

from circumspect.errors import GeometryError
from circumspect.pipeline.records import RecognitionResult, RecognitionStep
from circumspect.recording import RunRecorder


class StepRecorder:
    """Records what each frame led to, and ends the recording; a `PipelineObserver`."""

    def __init__(self, recorder: RunRecorder) -> None:
        self._recorder = recorder

    def on_step(self, step: RecognitionStep) -> None:
        """Record the answer so far and where the odometry frame lies."""
        extent = None
        try:
            points = step.model.cloud().points_xyz
            extent = np.stack([points.min(axis=0), points.max(axis=0)])
        except GeometryError:
            pass  # nothing of the object is known yet
        T_map_odom = None if step.pose is None else step.pose.T_map_odom
        self._recorder.answer(step.stamp, step.prediction, extent, T_map_odom)

    def on_end(self, result: RecognitionResult) -> None:  # noqa: ARG002 - answers are there already
        """Close the recording."""
        self._recorder.close()
