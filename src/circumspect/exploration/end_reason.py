"""End reasons of a scan, and the detection of a robot without progress."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from circumspect.geometry import PlanarPose

MIN_STEP_M = 0.04
MIN_TURN_RAD = float(np.radians(4.0))
"""Minimum turn that counts as progress."""


class ProgressWatch:
    """Detects a robot that makes no progress."""

    def __init__(self, patience: float) -> None:
        """Start without a pose.

        Args:
            patience: Time without progress until the robot is stuck [s].
        """
        self._patience = patience
        self._last: tuple[float, PlanarPose] | None = None

    def update(self, now: float, T_map_base: PlanarPose) -> bool:
        """Add a pose; return whether the robot has made no progress for too long.

        Args:
            now: Time [s].
            T_map_base: Estimated pose of the robot.
        """
        if self._last is None or self._made_progress(self._last[1], T_map_base):
            self._last = (now, T_map_base)
        return now - self._last[0] > self._patience

    @staticmethod
    def _made_progress(before: PlanarPose, after: PlanarPose) -> bool:
        step = before.inverse() @ after
        return bool(np.hypot(step.x, step.y) >= MIN_STEP_M or abs(step.yaw) >= MIN_TURN_RAD)


class EndReason(StrEnum):
    """Fixed reasons why a scan ends; the values are the texts in its file.

    The other reasons contain numbers, or come from the planner.
    """

    LOST = "lost: no pose has been reliable for too long"
    NO_OBJECT = "no object in view after a look round"
    INTERRUPTED = "interrupted"


class ScanEnded(Exception):  # noqa: N818 - not an error
    """Raised to end a scan; its message is the reason."""
