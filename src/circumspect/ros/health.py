"""How the node fares: what came in, what was left out and why."""

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

WELL, WARNING, ERROR = 0, 1, 2
SILENT = 3.0
"""So long without a message [s], and it is missing."""
RECENT = 5.0
"""A fault is told for so long after it happened [s]."""
MOST_REASONS = 20
"""Kinds of faults that are counted one by one."""


@dataclass(frozen=True)
class Status:
    """A status, as diagnostics have it.

    Attributes:
        level: `WELL`, `WARNING` or `ERROR`.
        text: In words.
        values: Told beside it.
    """

    level: int
    text: str
    values: dict[str, Any] = field(default_factory=dict)


class Health:
    """Counts; may be told and asked from any thread."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin with nothing counted.

        Args:
            clock: Gives the time [s].
        """
        self._clock = clock
        self._lock = threading.Lock()
        self._born = clock()
        self._heard: Counter[str] = Counter()
        self._last: dict[str, float] = {}
        self._faults: Counter[str] = Counter()
        self._fault: tuple[float, str] | None = None
        self._outcomes: Counter[str] = Counter()
        self._outcome: tuple[float, str] | None = None
        self._milliseconds = 0.0
        self.taken = self.dropped = 0
        self.with_odometry = True
        self._prediction: Prediction | None = None
        self._pose: PoseEstimate | None = None
        self._warning = ""

    def message(self, what: str) -> None:
        """A message of an input came: "depth", "camera info", …."""
        with self._lock:
            self._heard[what] += 1
            self._last[what] = self._clock()

    def fault(self, reason: str) -> None:
        """Something was left out."""
        with self._lock:
            known = reason in self._faults or len(self._faults) < MOST_REASONS
            self._faults[reason if known else "other reasons"] += 1
            self._fault = self._clock(), reason

    def frame(self, with_odometry: bool) -> None:
        """A frame is whole and waits for the pipeline."""
        with self._lock:
            self.taken += 1
            self.with_odometry = with_odometry

    def drop(self) -> None:
        """A frame had to give way to a newer one."""
        with self._lock:
            self.dropped += 1

    def step(self, step: RecognitionStep, milliseconds: float) -> None:
        """A frame went through the pipeline.

        Args:
            step: What it led to.
            milliseconds: How long that took [ms].
        """
        with self._lock:
            self._outcomes[step.outcome] += 1
            self._outcome = self._clock(), step.outcome
            self._milliseconds = milliseconds
            self._prediction, self._pose = step.prediction, step.pose
            self._warning = step.odometry_warning

    def settled(self, prediction: Prediction) -> None:
        """What is known when no more frames come for now.

        Args:
            prediction: Over all grids.
        """
        with self._lock:
            self._prediction = prediction

    def forget_answer(self) -> None:
        """The object is modelled anew."""
        with self._lock:
            self._prediction, self._pose = None, None

    def count(self, what: str) -> int:
        """How many messages of an input came."""
        with self._lock:
            return self._heard[what]

    def silent(self, what: str) -> bool:
        """Whether nothing of an input came for too long."""
        with self._lock:
            return self._clock() - self._last.get(what, self._born) > SILENT

    def status(self, running: bool, missing: str | None, lost: int) -> Status:
        """All of it.

        Args:
            running: Frames are taken.
            missing: What the inputs lack, in words; None where they are complete.
            lost: Messages that went missing on the wire.
        """
        with self._lock:
            level, text = self._judged(running, missing)
            values = {
                "state": "running" if running else "stopped",
                **self._answer(),
                **_placed(self._pose),
                **{f"{what} heard": number for what, number in sorted(self._heard.items())},
                "frames taken": self.taken,
                "frames dropped": self.dropped,
                "messages lost on the wire": lost,
                "time a frame [ms]": f"{self._milliseconds:.0f}",
                **{f"frames: {what}": number for what, number in self._outcomes.items()},
                **{f"left out: {why}": number for why, number in self._faults.items()},
            }
        return Status(level, text, values)

    def _judged(self, running: bool, missing: str | None) -> tuple[int, str]:
        now = self._clock()
        if not running:
            return WELL, "stopped; publish to the start topic to go on"
        if missing is not None:
            return ERROR, missing
        if self._fault is not None and now - self._fault[0] < RECENT:
            # Where frames go through all the same, it is no more than a warning.
            through = self._outcome is not None and now - self._outcome[0] < RECENT
            return (WARNING if through else ERROR), f"left out: {self._fault[1]}"
        if self._outcome is None:
            return WARNING, "waiting for the first frame"
        if now - self._outcome[0] > RECENT:
            return WARNING, "no frame went through the pipeline lately"
        if self._pose is not None and not self._pose.reliable:
            return WARNING, f"pose not reliable: {self._pose.reason}"
        if self._warning:
            return WARNING, self._warning
        if self._outcome[1] != FrameOutcome.CLASSIFIED:
            return WARNING, str(self._outcome[1])
        if not self.with_odometry:
            return WARNING, "no odometry at the time of the frames: poses by registration alone"
        if self._prediction is not None and (why := self._prediction.reason):
            return WELL, f"the object is in view and named, not confident: {why}"
        return WELL, "the object is in view and named"

    def _answer(self) -> dict[str, str]:
        told = self._prediction
        if told is None:
            return {"answer": "none yet"}
        coverage = "unknown" if told.coverage is None else f"{told.coverage:.2f}"
        return {
            "answer": told.label,
            "confident": _yes_or_no(told.confident),
            "reason": told.reason,
            "in_distribution": _yes_or_no(told.in_distribution),
            "probability": f"{told.probability:.3f}",
            "alternatives": ", ".join(f"{name} {p:.3f}" for name, p in told.alternatives.items()),
            "coverage": coverage,
        }


def _yes_or_no(value: bool) -> str:
    return "yes" if value else "no"


def _placed(pose: PoseEstimate | None) -> dict[str, str]:
    """How well the place of the latest frame is known."""
    if pose is None or pose.sigmas is None:
        return {}
    turn, place = pose.sigmas
    return {
        "pose state": str(pose.state),
        "pose accurate": _yes_or_no(pose.accurate),
        "pose, standard deviation [mm]": f"{1e3 * place:.0f}",
        "pose, standard deviation [°]": f"{np.degrees(turn):.1f}",
    }
