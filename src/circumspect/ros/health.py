"""Status of the node: received messages, skipped frames and reasons."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from circumspect.classification import Prediction
from circumspect.recognition import FrameOutcome, RecognitionStep
from circumspect.tracking import PoseEstimate

OK, WARNING, ERROR = 0, 1, 2
MAX_SILENCE_S = 3.0
"""Time without a message after which an input counts as missing [s]."""
RECENT_S = 5.0
"""Time for which an error determines the status [s]."""
MAX_REASONS = 20
"""Maximum number of reasons that are counted separately."""


@dataclass(frozen=True)
class Status:
    """A status for diagnostics.

    Attributes:
        level: `OK`, `WARNING` or `ERROR`.
        text: Description.
        values: Additional values.
    """

    level: int
    text: str
    values: dict[str, Any] = field(default_factory=dict)


class Health:
    """Counters of the node; thread-safe.

    Attributes:
        taken: Frames passed to the queue.
        dropped: Frames dropped because newer ones arrived.
        with_odometry: Whether the last frame had odometry.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Start with all counters at zero.

        Args:
            clock: Current time [s].
        """
        self._clock = clock
        self._lock = threading.Lock()
        self._created = clock()
        self._received: Counter[str] = Counter()
        self._last: dict[str, float] = {}
        self._errors: Counter[str] = Counter()
        self._last_error: tuple[float, str] | None = None
        self._outcomes: Counter[str] = Counter()
        self._outcome: tuple[float, str] | None = None
        self._milliseconds = 0.0
        self.taken = self.dropped = 0
        self.with_odometry = True
        self._prediction: Prediction | None = None
        self._pose: PoseEstimate | None = None
        self._warning = ""

    def on_message(self, what: str) -> None:
        """Count a message of an input: "depth", "camera info", …."""
        with self._lock:
            self._received[what] += 1
            self._last[what] = self._clock()

    def report_error(self, reason: str) -> None:
        """Count a skipped message or frame."""
        with self._lock:
            known = reason in self._errors or len(self._errors) < MAX_REASONS
            self._errors[reason if known else "other reasons"] += 1
            self._last_error = self._clock(), reason

    def on_frame(self, with_odometry: bool) -> None:
        """Count a frame that is ready for the pipeline."""
        with self._lock:
            self.taken += 1
            self.with_odometry = with_odometry

    def on_drop(self) -> None:
        """Count a frame that was dropped for a newer one."""
        with self._lock:
            self.dropped += 1

    def on_step(self, step: RecognitionStep, milliseconds: float) -> None:
        """Record the result of a frame.

        Args:
            step: Result of the pipeline.
            milliseconds: Processing time [ms].
        """
        with self._lock:
            self._outcomes[step.outcome] += 1
            self._outcome = self._clock(), step.outcome
            self._milliseconds = milliseconds
            self._prediction, self._pose = step.prediction, step.pose
            self._warning = step.odometry_warning

    def on_finalised(self, prediction: Prediction) -> None:
        """Record the final answer while no more frames arrive.

        Args:
            prediction: Prediction from all grids.
        """
        with self._lock:
            self._prediction = prediction

    def reset(self) -> None:
        """Forget the answer, because a new model is started."""
        with self._lock:
            self._prediction, self._pose = None, None

    def count(self, what: str) -> int:
        """Number of messages of an input."""
        with self._lock:
            return self._received[what]

    def is_silent(self, what: str) -> bool:
        """Whether an input has been missing for too long."""
        with self._lock:
            return self._clock() - self._last.get(what, self._created) > MAX_SILENCE_S

    def status(self, running: bool, missing: str | None, lost: int) -> Status:
        """The current status.

        Args:
            running: Whether frames are processed.
            missing: Description of missing input; None if complete.
            lost: Messages lost in transport.
        """
        with self._lock:
            level, text = self._level_and_text(running, missing)
            values = {
                "state": "running" if running else "stopped",
                **self._answer(),
                **_pose_values(self._pose),
                **{f"{what} received": number for what, number in sorted(self._received.items())},
                "frames taken": self.taken,
                "frames dropped": self.dropped,
                "messages lost in transport": lost,
                "time per frame [ms]": f"{self._milliseconds:.0f}",
                **{f"frames: {what}": number for what, number in self._outcomes.items()},
                **{f"skipped: {why}": number for why, number in self._errors.items()},
            }
        return Status(level, text, values)

    def _level_and_text(self, running: bool, missing: str | None) -> tuple[int, str]:
        now = self._clock()
        if not running:
            return OK, "stopped; publish to the start topic to resume"
        if missing is not None:
            return ERROR, missing
        if self._last_error is not None and now - self._last_error[0] < RECENT_S:
            # As long as other frames are processed, it is only a warning.
            is_processing = self._outcome is not None and now - self._outcome[0] < RECENT_S
            return (WARNING if is_processing else ERROR), f"skipped: {self._last_error[1]}"
        if self._outcome is None:
            return WARNING, "waiting for the first frame"
        if now - self._outcome[0] > RECENT_S:
            return WARNING, "no frame was processed recently"
        if self._pose is not None and not self._pose.reliable:
            return WARNING, f"pose not reliable: {self._pose.reason}"
        if self._warning:
            return WARNING, self._warning
        if self._outcome[1] != FrameOutcome.CLASSIFIED:
            return WARNING, str(self._outcome[1])
        if not self.with_odometry:
            return WARNING, "no odometry at the time of the frames: poses from registration only"
        if self._prediction is not None and (why := self._prediction.reason):
            return OK, f"the object is visible and classified, not confident: {why}"
        return OK, "the object is visible and classified"

    def _answer(self) -> dict[str, str]:
        prediction = self._prediction
        if prediction is None:
            return {"answer": "none"}
        coverage = "unknown" if prediction.coverage is None else f"{prediction.coverage:.2f}"
        return {
            "answer": prediction.label,
            "confident": _yes_or_no(prediction.confident),
            "reason": prediction.reason,
            "in_distribution": _yes_or_no(prediction.in_distribution),
            "probability": f"{prediction.probability:.3f}",
            "alternatives": ", ".join(
                f"{name} {p:.3f}" for name, p in prediction.alternatives.items()
            ),
            "coverage": coverage,
        }


def _yes_or_no(value: bool) -> str:
    return "yes" if value else "no"


def _pose_values(pose: PoseEstimate | None) -> dict[str, str]:
    """Accuracy of the pose of the latest frame."""
    if pose is None or pose.sigmas is None:
        return {}
    turn, place = pose.sigmas
    return {
        "pose state": str(pose.state),
        "pose accurate": _yes_or_no(pose.accurate),
        "pose, standard deviation [mm]": f"{1e3 * place:.0f}",
        "pose, standard deviation [°]": f"{np.degrees(turn):.1f}",
    }
