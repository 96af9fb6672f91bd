"""Writes down where something was while it moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from circumspect.geometry.growing_table import GrowingTable
from circumspect.geometry.trajectory import Trajectory

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform


class TrajectoryLog:
    """Poses in the order in which they come; one that is not later than all before is left out."""

    def __init__(self) -> None:
        """Begin empty."""
        self._stamps = GrowingTable(1)
        self._matrices = GrowingTable(16)
        self._last = float("-inf")

    def __len__(self) -> int:
        return len(self._stamps)

    def is_news(self, stamp: float) -> bool:
        """Whether a time is later than all before."""
        return stamp > self._last

    def add(self, stamp: float, T_map_camera: RigidTransform) -> None:
        """Take down one pose.

        Args:
            stamp: Its time [s].
            T_map_camera: A single pose.
        """
        if self.is_news(stamp):
            self._last = stamp
            self._stamps.append(stamp)
            self._matrices.append(T_map_camera.as_matrix())

    @property
    def trajectory(self) -> Trajectory | None:
        """All poses so far, to the last bit as they were given; None of none."""
        if not len(self):
            return None
        from scipy.spatial.transform import RigidTransform

        matrices = self._matrices.rows.reshape(-1, 4, 4)
        return Trajectory(self._stamps.rows[:, 0], RigidTransform(matrices, normalize=False))
