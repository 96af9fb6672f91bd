"""How far the robot drove."""

from __future__ import annotations

import numpy as np

from circumspect.geometry import PlanarPose

MOST = 2.0
"""Times what was commanded: a longer step is a jump of the odometry, or a corrected pose."""


class DrivenWay:
    """Sums up the way, by the poses of frames where these are reliable.

    Between two frames, and where poses are not reliable, it is what the wheels say; over a stretch
    without reliable poses at least what lies between its ends, for wheels may be stuck.
    """

    def __init__(self) -> None:
        """Nothing was driven yet."""
        self._until_frame = self._wheels = self._commanded = self._speed = 0.0
        self._now: float | None = None
        self._T_odom_base: PlanarPose | None = None
        self._T_map_base: PlanarPose | None = None
        self._doubtful = False

    @property
    def metres(self) -> float:
        """All of it [m]."""
        return self._until_frame + self._wheels

    def told(self, speed: float) -> None:
        """From the time of the last `went` on the robot is to drive at another speed [m/s]."""
        self._speed = abs(speed)

    def went(self, now: float, T_odom_base: PlanarPose | None) -> None:
        """Take what was driven since the last time.

        Args:
            now: The time, which stands still while somebody holds the robot [s].
            T_odom_base: Where the wheels say to be; None where they say nothing.
        """
        commanded = 0.0 if self._now is None else self._speed * (now - self._now)
        wheels, before = commanded, self._T_odom_base
        if before is not None and T_odom_base is not None:
            wheels = min(float(np.linalg.norm(T_odom_base.xy - before.xy)), MOST * commanded)
        self._commanded += commanded
        self._wheels += wheels
        self._now, self._T_odom_base = now, T_odom_base

    def placed(self, T_map_base: PlanarPose | None) -> None:
        """Take where a frame was taken from.

        Args:
            T_map_base: Of the base; None where that is not reliable.
        """
        if T_map_base is None:
            self._doubtful = True
            return
        self._until_frame += self._step(T_map_base)
        self._wheels = self._commanded = 0.0
        self._T_map_base, self._doubtful = T_map_base, False

    def _step(self, T_map_base: PlanarPose) -> float:
        """From the last reliable pose to this one [m]."""
        if self._T_map_base is None:
            return self._wheels
        away = float(np.linalg.norm(T_map_base.xy - self._T_map_base.xy))
        chord = min(away, MOST * self._commanded)
        # Nobody saw how the robot came there.
        return max(chord, self._wheels) if self._doubtful else chord
