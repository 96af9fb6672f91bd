"""How far the robot drove."""

from __future__ import annotations

import numpy as np

from circumspect.geometry import PlanarPose

MOST = 2.0
"""Times what was commanded: more is no way driven, but odometry that jumps, or a pose corrected."""


class DrivenWay:
    """Sums up the way by the poses of frames, and by the wheels where there is no certain pose.

    Wheels that are stuck, slip or jump count only until the next frame that is placed.
    """

    def __init__(self) -> None:
        """Nothing was driven yet."""
        self._until_frame = self._wheels = self._commanded = 0.0
        self._T_map_base: PlanarPose | None = None

    @property
    def metres(self) -> float:
        """All of it [m]."""
        return self._until_frame + self._wheels

    def moved(self, commanded: float, wheels: float | None) -> None:
        """Take a short drive.

        Args:
            commanded: What it should have been [m].
            wheels: What the wheels say [m]; None where they say nothing.
        """
        self._commanded += commanded
        self._wheels += commanded if wheels is None else min(wheels, MOST * commanded)

    def placed(self, T_map_base: PlanarPose | None) -> None:
        """Take where a frame was taken from.

        Args:
            T_map_base: Of the base; None where that is not certain.
        """
        step, before = self._wheels, self._T_map_base
        if before is not None and T_map_base is not None:
            away = float(np.linalg.norm(T_map_base.xy - before.xy))
            step = min(away, MOST * self._commanded)
        self._until_frame += step
        self._wheels = self._commanded = 0.0
        self._T_map_base = T_map_base
