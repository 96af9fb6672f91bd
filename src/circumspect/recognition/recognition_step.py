"""The result of one frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.grid import OccupancyGrid
from circumspect.planning import Answer
from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.reconstruction import ObjectModel
from circumspect.tracking import PoseEstimate

ANSWER_KEYS = (
    "label", "in_distribution", "in_distribution_probability", "confident", "reason",
    "probability", "probabilities", "alternatives",
)  # fmt: skip
"""Of an answer in logs and results; see `Prediction.to_dict`."""


@dataclass(frozen=True, eq=False)
class RecognitionStep:
    """The result of one frame.

    Attributes:
        index: Number of the frame in this run, from 0.
        stamp: Its time [s].
        outcome: What came of the frame.
        pose: The estimated pose; None if it was not estimated.
        object_pixels: Pixels of the frame that show the object.
        coverage: Share of the azimuth from which the object has been seen, 0 … 1.
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
        """The answer in the form that planners take; None if there is none."""
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
    """The answer as logs and results hold it, in JSON types.

    Args:
        prediction: The answer; without one its entries are None, and it is not confident.
    """
    if prediction is None:
        return {**dict.fromkeys(ANSWER_KEYS), "confident": False}
    answer = prediction.to_dict()
    return {key: answer[key] for key in ANSWER_KEYS}


def prediction_text(prediction: Prediction | None) -> str:
    """A prediction in the `repr` of a record."""
    return "no prediction" if prediction is None else repr(prediction)
