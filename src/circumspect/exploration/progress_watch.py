"""Notices that a robot does not get on."""

from __future__ import annotations

import numpy as np

from circumspect.geometry import PlanarPose

STEP = 0.04
"""Progress is to get this far [m] …"""
TURN = float(np.radians(4.0))
"""… or to turn by this [rad]."""


class ProgressWatch:
    """Remembers the last place at which the robot made progress."""

    def __init__(self, patience: float) -> None:
        """Begin to watch.

        Args:
            patience: So long without progress is too long [s].
        """
        self._patience = patience
        self._last: tuple[float, PlanarPose] | None = None

    def stuck(self, now: float, T_map_base: PlanarPose) -> bool:
        """Whether there was no progress for too long.

        Args:
            now: Time [s].
            T_map_base: Where the robot is believed to be.
        """
        if self._last is None or self._got_on(self._last[1], T_map_base):
            self._last = (now, T_map_base)
        return now - self._last[0] > self._patience

    @staticmethod
    def _got_on(before: PlanarPose, after: PlanarPose) -> bool:
        step = before.inverse() @ after
        return bool(np.hypot(step.x, step.y) >= STEP or abs(step.yaw) >= TURN)
