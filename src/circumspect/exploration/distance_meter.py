"""Measures how far the robot drove."""

from __future__ import annotations

import numpy as np

from circumspect.geometry import PlanarPose

MAX_COMMANDED_RATIO = 2.0
"""A step longer than this many times the commanded one is a jump of the odometry, or a corrected
pose."""


class DistanceMeter:
    """Sums up the distances between the reliable poses of frames.

    Between two frames, and without reliable poses, the distance is that of the odometry. Over a
    segment without reliable poses it is at least the distance between its ends: wheels may be
    stuck.
    """

    def __init__(self) -> None:
        """Start at 0 m."""
        self._until_frame = self._wheels = self._commanded = self._speed = 0.0
        self._now: float | None = None
        self._T_odom_base: PlanarPose | None = None
        self._T_map_base: PlanarPose | None = None
        self._is_unreliable = False

    @property
    def metres(self) -> float:
        """The distance so far [m]."""
        return self._until_frame + self._wheels

    def set_speed(self, speed: float) -> None:
        """Set the commanded speed [m/s] from the last `add_odometry` on."""
        self._speed = abs(speed)

    def add_odometry(self, now: float, T_odom_base: PlanarPose | None) -> None:
        """Add the distance since the last call.

        Args:
            now: The time, which stands still while somebody holds the robot [s].
            T_odom_base: Pose by wheel odometry; None if there is none.
        """
        commanded = 0.0 if self._now is None else self._speed * (now - self._now)
        wheels, before = commanded, self._T_odom_base
        if before is not None and T_odom_base is not None:
            wheels = min(
                float(np.linalg.norm(T_odom_base.xy - before.xy)), MAX_COMMANDED_RATIO * commanded
            )
        self._commanded += commanded
        self._wheels += wheels
        self._now, self._T_odom_base = now, T_odom_base

    def add_pose(self, T_map_base: PlanarPose | None) -> None:
        """Add the pose of a frame.

        Args:
            T_map_base: Pose of the base; None if it is not reliable.
        """
        if T_map_base is None:
            self._is_unreliable = True
            return
        self._until_frame += self._step(T_map_base)
        self._wheels = self._commanded = 0.0
        self._T_map_base, self._is_unreliable = T_map_base, False

    def _step(self, T_map_base: PlanarPose) -> float:
        """Distance from the last reliable pose to this one [m]."""
        if self._T_map_base is None:
            return self._wheels
        away = float(np.linalg.norm(T_map_base.xy - self._T_map_base.xy))
        chord = min(away, MAX_COMMANDED_RATIO * self._commanded)
        # The path between the two poses is unknown.
        return max(chord, self._wheels) if self._is_unreliable else chord
