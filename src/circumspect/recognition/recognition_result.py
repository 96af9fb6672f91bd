"""The result of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import Prediction
from circumspect.recognition.recognition_step import RecognitionStep, prediction_text


@dataclass(frozen=True, eq=False)
class RecognitionResult:
    """The steps of a run and how it ended.

    The poses of the steps are those that were known when the run ended. Loop closures have
    corrected them.

    Attributes:
        steps: One for each frame; only the last one holds model and grid.
        interrupted: Whether the run ended before its frames did.
        end_reason: Why it was interrupted, in words; empty if it was not, or by Ctrl-C.
    """

    steps: tuple[RecognitionStep, ...]
    interrupted: bool = False
    end_reason: str = ""

    def __repr__(self) -> str:
        ended = ", interrupted" if self.interrupted else ""
        text = prediction_text(self.prediction)
        return f"RecognitionResult({len(self.steps)} steps, {text}{ended})"

    @property
    def last(self) -> RecognitionStep | None:
        """The latest step, which holds the final model, grid and prediction; None without any."""
        return self.steps[-1] if self.steps else None

    @property
    def lost_from(self) -> int | None:
        """Number of the frame from which on the camera was lost to the end; None if it was not.

        The camera is lost to the end if the last estimated pose is `PoseEstimate.lost`. The frames
        after the last reliable pose are counted.
        """
        first, lost = None, None
        for step in reversed(self.steps):
            if step.pose is None:
                continue
            if step.pose.reliable:
                break
            lost = step.pose.lost if lost is None else lost
            first = step.index
        return first if lost else None

    @property
    def prediction(self) -> Prediction | None:
        """The final answer; None if the object was never seen."""
        return None if self.last is None else self.last.prediction

    @property
    def points_xyz(self) -> NDArray[np.float64]:
        """(n, 3) [m] of the final model; empty if there is none, or if it is too wide."""
        if self.last is None or self.last.grid is None:
            return np.empty((0, 3))
        return self.last.model.cloud().points_xyz

    @property
    def confident(self) -> bool:
        """See `RecognitionStep.confident`; of the final answer."""
        return self.last is not None and self.last.confident
