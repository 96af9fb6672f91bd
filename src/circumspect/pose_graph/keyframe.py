"""Keyframes: the frames that the map consists of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3_matrices
from circumspect.registration import CompactSurface, FreeSpace, ScanSurface


@dataclass(frozen=True, eq=False)
class Keyframe:
    """A pose of the graph with its surface and free space.

    Attributes:
        number: Number of the keyframe, in the order of time.
        T_map_camera: (4, 4) current estimate of the pose.
        covariance: (6, 6) marginal covariance of the pose since the first keyframe [rad, m].
        compact: Observed surface, optical frame.
        free_space: Observed free space.
        depth: Median depth of its scan, at least `MIN_DEPTH_M` [m].
        T_base_camera: (4, 4) mount of the camera; None if unknown.
    """

    number: int
    T_map_camera: NDArray[np.floating]
    covariance: NDArray[np.floating]
    compact: CompactSurface
    free_space: FreeSpace
    depth: float
    T_base_camera: NDArray[np.floating] | None = None

    @property
    def surface(self) -> ScanSurface:
        """The surface in double precision."""
        return self.compact.expanded()

    def shows(
        self,
        points_xyz: NDArray[np.floating],
        normals_xyz: NDArray[np.floating],
        max_distance: float,
    ) -> NDArray[np.bool_]:
        """Which surface points are visible from this keyframe on their front side.

        Args:
            points_xyz: (n, 3) [m] map frame.
            normals_xyz: (n, 3) map frame.
            max_distance: Largest difference from the measured depth [m].
        """
        points = self._in_camera(points_xyz)
        facing = np.einsum("ij,ij->i", points, normals_xyz @ self.T_map_camera[:3, :3]) < 0
        return facing & self.free_space.agrees_with(points, max_distance)

    def sees_through(self, points_xyz: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Which points (n, 3) [m], map frame, lie in the free space in front of this keyframe."""
        return self.free_space.contains(self._in_camera(points_xyz))

    def _in_camera(self, points_xyz: NDArray[np.floating]) -> NDArray[np.floating]:
        return (points_xyz - self.T_map_camera[:3, 3]) @ self.T_map_camera[:3, :3]

    def relative_pose(self, T_map_camera: NDArray[np.floating]) -> NDArray[np.floating]:
        """(4, 4) `T_keyframe_camera` of a camera."""
        return se3_matrices.inverse(self.T_map_camera) @ T_map_camera
