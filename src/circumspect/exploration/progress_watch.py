"""Detects that a robot does not make progress."""

from __future__ import annotations

import numpy as np

from circumspect.geometry import PlanarPose

MIN_STEP_M = 0.04
MIN_TURN_RAD = float(np.radians(4.0))
"""Progress is a step or a turn of at least this."""


class ProgressWatch:
    """Keeps the last pose at which the robot made progress."""

    def __init__(self, patience: float) -> None:
        """Start without a pose.

        Args:
            patience: Time without progress until the robot is stuck [s].
        """
        self._patience = patience
        self._last: tuple[float, PlanarPose] | None = None

    def stuck(self, now: float, T_map_base: PlanarPose) -> bool:
        """Whether the robot has made no progress for too long.

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
