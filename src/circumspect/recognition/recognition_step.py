"""The results of one frame and of a run."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.errors import InputError
from circumspect.grid import OccupancyGrid
from circumspect.planning import Answer
from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.reconstruction import ObjectModel
from circumspect.storage import write_json
from circumspect.tracking import PoseEstimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ANSWER_KEYS = (
    "label", "in_distribution", "in_distribution_probability", "confident", "reason",
    "probability", "probabilities", "alternatives",
)  # fmt: skip
"""Keys of an answer in logs and results; see `Prediction.to_dict`."""


@dataclass(frozen=True, eq=False)
class RecognitionStep:
    """The result of one frame.

    Attributes:
        index: Number of the frame in this run, from 0.
        stamp: Its time [s].
        outcome: Outcome of the frame.
        pose: The estimated pose; None if it was not estimated.
        object_pixels: Pixels of the frame that show the object.
        coverage: Fraction of the azimuth from which the object has been seen, 0 … 1.
        model: The object so far.
        grid: Its occupancy grid, from the preview model until no more frames come; None before the
            first classified frame.
        prediction: The answer so far, see `RecognitionPipeline.prediction`; None before the first
            classified frame.
        milliseconds: Stage to time spent [ms].
        odometry_warning: Why odometry is not used; empty if it is, or if the frame has none.
    """

    index: int
    stamp: float
    outcome: FrameOutcome
    pose: PoseEstimate | None
    object_pixels: int
    coverage: float
    model: ObjectModel
    grid: OccupancyGrid | None
    prediction: Prediction | None
    milliseconds: Mapping[str, float] = field(default_factory=dict)
    odometry_warning: str = ""

    def __repr__(self) -> str:
        text = prediction_text(self.prediction)
        return f"RecognitionStep(frame {self.index}, {self.outcome.value!r}, {text})"

    @property
    def confident(self) -> bool:
        """Whether the answer may be acted on; see `Prediction.confident`."""
        return self.prediction is not None and self.prediction.confident

    @property
    def answer(self) -> Answer | None:
        """The answer in the form of the planners' input; None if there is none."""
        p = self.prediction
        if p is None:
            return None
        return Answer(p.probabilities, self.coverage, p.in_distribution, p.confident)

    def at(self, T_map_camera: RigidTransform) -> RecognitionStep:
        """The step with a corrected pose; unchanged if it has none."""
        if self.pose is None:
            return self
        return replace(self, pose=self.pose.at(T_map_camera))

    def summary(self) -> dict[str, Any]:
        """The record in JSON types, without arrays."""
        position = None if self.pose is None else self.pose.T_map_camera.translation.tolist()
        sigmas = None if self.pose is None else self.pose.sigmas
        return {
            "frame": self.index,
            "stamp": self.stamp,
            "outcome": self.outcome.value,
            "odometry_warning": self.odometry_warning,
            **answer_record(self.prediction),
            "coverage": self.coverage,
            "object_pixels": self.object_pixels,
            "points": len(self.model.preview.sums),
            "camera_xyz": position,
            "converged": None if self.pose is None else self.pose.converged,
            "inliers": None if self.pose is None else self.pose.inliers,
            "residual": None if self.pose is None else self.pose.residual,
            "state": None if self.pose is None else self.pose.state,
            "pose_reason": None if self.pose is None else self.pose.reason,
            "source": None if self.pose is None else self.pose.source,
            "reliable": None if self.pose is None else self.pose.reliable,
            "accurate": None if self.pose is None else self.pose.accurate,
            "deviation_rad": None if sigmas is None else sigmas[0],
            "deviation_m": None if sigmas is None else sigmas[1],
            "milliseconds": {name: round(ms, 3) for name, ms in self.milliseconds.items()},
        }


def answer_record(prediction: Prediction | None) -> dict[str, Any]:
    """The record of an answer in logs and results, JSON types.

    Args:
        prediction: The answer; if None, its entries are None and it is not confident.
    """
    if prediction is None:
        return {**dict.fromkeys(ANSWER_KEYS), "confident": False}
    answer = prediction.to_dict()
    return {key: answer[key] for key in ANSWER_KEYS}


def prediction_text(prediction: Prediction | None) -> str:
    """A prediction in the `repr` of a record."""
    return "no prediction" if prediction is None else repr(prediction)


@dataclass(frozen=True, eq=False)
class RecognitionResult:
    """The steps of a run and its end.

    The poses of the steps are those at the end of the run, corrected by loop closures.

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
        """Number of the first frame after the last reliable pose, if the camera ended lost.

        None if the last estimated pose is not `PoseEstimate.lost`.
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
        """Whether the final answer may be acted on; see `RecognitionStep.confident`."""
        return self.last is not None and self.last.confident

    @property
    def answers(self) -> tuple[list[Prediction | None], list[bool]]:
        """The answer after each step, None before the first, and whether its frame was used."""
        used = [step.outcome == FrameOutcome.CLASSIFIED for step in self.steps]
        return [step.prediction for step in self.steps], used

    def to_dict(self) -> dict[str, Any]:
        """The answer and a summary of the run, in JSON types, without arrays."""
        last = self.last
        return {
            **answer_record(self.prediction),
            "frames": len(self.steps),
            "outcomes": dict(Counter(step.outcome.value for step in self.steps)),
            "lost_from": self.lost_from,
            "coverage": 0.0 if last is None else last.coverage,
            "points": len(self.points_xyz),
            "interrupted": self.interrupted,
            "end_reason": self.end_reason or None,
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_dict` as JSON; a `RunFolder` also writes model, grid and path.

        Raises:
            OutputError: The file cannot be written.
        """
        write_json(path, self.to_dict())

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the probabilities of the leading classes over the frames.

        Args:
            axes: Axes to draw into; None for a new figure.

        Raises:
            InputError: The run has no frame.
            MissingExtraError: matplotlib is not installed.
        """
        from circumspect.figure_canvas import axes_or_new
        from circumspect.recognition.answer_plot import draw_answers

        if not self.steps:
            raise InputError("a run without a frame has nothing to draw")
        axes = axes_or_new(axes)
        draw_answers(axes, *self.answers, np.arange(1.0, len(self.steps) + 1.0), "frame")
        return axes
