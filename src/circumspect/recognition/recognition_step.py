"""What the pipeline tells: one record a frame, one at the end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.errors import CircumspectError
from circumspect.grid import OccupancyGrid
from circumspect.planning import Answer
from circumspect.reconstruction import ObjectModel
from circumspect.robot import RunStopped
from circumspect.tracking import PoseEstimate

ANSWER_KEYS = (
    "label", "in_distribution", "in_distribution_probability", "confident", "reason",
    "probability", "probabilities", "alternatives",
)  # fmt: skip
"""Of an answer in logs and results; see `Prediction.to_dict`."""
CLASSIFIED = "classified"
OUT_OF_ORDER = "not later than the frame before"
WRONG_UNIT = "depths that no camera has; are they in metres?"
NO_DEPTH = "no depth in the frame"
NO_OBJECT = "no object in view"
NO_POSE = "the pose is not reliable"
TOO_LITTLE = "too little of the object seen to span a shape"
TOO_WIDE = "what stands there is too wide for an object; is it the room?"


@dataclass(frozen=True, eq=False)
class RecognitionStep:
    """What one frame led to.

    Attributes:
        index: Number of the frame in this run, from 0.
        stamp: Its time [s].
        outcome: `CLASSIFIED`, or the reason why the frame added nothing.
        pose: Where it was taken from; None where that was not looked into.
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
    outcome: str
    pose: PoseEstimate | None
    object_pixels: int
    coverage: float
    model: ObjectModel
    grid: OccupancyGrid | None
    prediction: Prediction | None
    milliseconds: Mapping[str, float] = field(default_factory=dict)
    odometry_warning: str = ""

    def __repr__(self) -> str:
        return f"RecognitionStep(frame {self.index}, {self.outcome!r}, {_told(self.prediction)})"

    @property
    def confident(self) -> bool:
        """Whether there is an answer that may be acted on; see `Prediction.confident`."""
        return self.prediction is not None and self.prediction.confident

    @property
    def answer(self) -> Answer | None:
        """The answer as planners take it; None where there is none."""
        told = self.prediction
        if told is None:
            return None
        return Answer(told.probabilities, self.coverage, told.in_distribution, told.confident)

    def at(self, T_map_camera: RigidTransform) -> RecognitionStep:
        """The same with a corrected pose; as it is where it has none."""
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
            "outcome": self.outcome,
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


@dataclass(frozen=True, eq=False)
class RecognitionResult:
    """What a run led to.

    Attributes:
        steps: One for each frame; only the last one holds model and grid.
        interrupted: The run ended before its frames did …
        end_reason: … for this reason, in words; empty where that was Ctrl-C.

    The poses of the steps are those that were known when the run ended: where the way round the
    object closed, they are corrected.
    """

    steps: tuple[RecognitionStep, ...]
    interrupted: bool = False
    end_reason: str = ""

    def __repr__(self) -> str:
        ended = ", interrupted" if self.interrupted else ""
        return f"RecognitionResult({len(self.steps)} steps, {_told(self.prediction)}{ended})"

    @property
    def last(self) -> RecognitionStep | None:
        """The latest step, which holds the final model, grid and prediction; None without any."""
        return self.steps[-1] if self.steps else None

    @property
    def lost_from(self) -> int | None:
        """Number of the frame from which on the camera was lost to the end; None where it was not.

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
        """The final answer; None where the object was never seen."""
        return None if self.last is None else self.last.prediction

    @property
    def points_xyz(self) -> NDArray[np.float64]:
        """(n, 3) [m] of the final model; none where nothing is known of it, or it is too wide."""
        if self.last is None or self.last.grid is None:
            return np.empty((0, 3))
        return self.last.model.cloud().points_xyz

    @property
    def confident(self) -> bool:
        """See `RecognitionStep.confident`; of the final answer."""
        return self.last is not None and self.last.confident


def answer_record(prediction: Prediction | None) -> dict[str, Any]:
    """The answer as logs and results hold it, in JSON types.

    Args:
        prediction: The answer; without one its entries are None, and it is not confident.
    """
    if prediction is None:
        return {**dict.fromkeys(ANSWER_KEYS), "confident": False}
    answer = prediction.to_dict()
    return {key: answer[key] for key in ANSWER_KEYS}


def reason_of_end(cause: BaseException | None) -> str:
    """Why a run ended early, in words; empty where it did not, or by Ctrl-C."""
    if not isinstance(cause, Exception):
        return ""
    return str(cause) if isinstance(cause, CircumspectError | RunStopped) else repr(cause)


def _told(prediction: Prediction | None) -> str:
    return "no prediction" if prediction is None else repr(prediction)


class PipelineObserver(Protocol):
    """Watches a run: a screen, a folder, a dashboard."""

    def on_step(self, step: RecognitionStep) -> None:
        """A frame went through."""

    def on_end(self, result: RecognitionResult) -> None:
        """The run is over, in whatever way it ended."""


def tell_end(observers: Sequence[PipelineObserver], result: RecognitionResult) -> None:
    """Tell all observers, whatever becomes of one; then the first fault goes on."""
    faults: list[Exception] = []
    for observer in observers:
        try:
            observer.on_end(result)
        except Exception as fault:
            faults.append(fault)
    if faults:
        raise faults[0]
