"""What is known of the whole scene: the target of registration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.voxel_sums import VoxelSums, patch_keys
from circumspect.mapping import _native
from circumspect.mapping.scan_surface import ScanSurface

if TYPE_CHECKING:
    from small_gicp import KdTree

CELL = 0.07
"""Side of the cells in which planes are looked up [m]: a little more than how far one looks."""
# Columns of the sums: information (of points), times point (3), times normal (3), squared times
# the variance of the normal's slope, squared times the unevenness.
_WEIGHT, _POINT, _NORMAL, _SLOPE, _UNEVENNESS, _COLUMNS = 0, slice(1, 4), slice(4, 7), 7, 8, 9


@dataclass(frozen=True, eq=False)
class SceneMap:
    """Object, floor, walls and clutter as mean points with normals, map frame.

    The two sides of a thin board are averaged apart, even within one voxel.

    Attributes:
        voxel: Side of the voxels over which points are averaged [m].
        sums: Sums over the scans, for each voxel and each of six ways that a surface may turn.
    """

    voxel: float = 0.03
    sums: VoxelSums = field(default_factory=lambda: VoxelSums.empty(_COLUMNS))

    def __len__(self) -> int:
        return len(self.sums)

    def with_surface(self, surface: ScanSurface, T_map_camera: RigidTransform) -> SceneMap:
        """The map with one more scan.

        Args:
            surface: What the scan shows.
            T_map_camera: Where it was taken from.
        """
        return self.with_surfaces([(surface, T_map_camera)])

    def with_surfaces(self, surfaces: Sequence[tuple[ScanSurface, RigidTransform]]) -> SceneMap:
        """The map with more scans; see `with_surface`."""
        keys, columns = [np.empty(0, np.int64)], [np.empty((0, _COLUMNS))]
        for surface, T_map_camera in surfaces:
            scan, normals_xyz = surface.scan, surface.normals_xyz
            known = np.einsum("ij,ij->i", normals_xyz, normals_xyz) > 0.5
            matrix = T_map_camera.as_matrix()
            points = scan.points_xyz[known] @ matrix[:3, :3].T + matrix[:3, 3]
            weights = scan.sigmas[known, None] ** -2
            normals = normals_xyz[known] @ matrix[:3, :3].T
            keys.append(patch_keys(points, normals, self.voxel))
            further = np.column_stack([surface.slopes[known], surface.unevenness[known]])
            columns.append(
                np.hstack([weights, weights * points, weights * normals, weights**2 * further])
            )
        added = VoxelSums.from_rows(np.concatenate(keys), np.concatenate(columns))
        return SceneMap(self.voxel, self.sums.plus(added))

    @cached_property
    def points_xyz(self) -> NDArray[np.float64]:
        """(n, 3) [m]."""
        return self.sums.totals[:, _POINT] / self.sums.totals[:, _WEIGHT, None]

    @cached_property
    def normals_xyz(self) -> NDArray[np.float64]:
        """(n, 3) unit vectors."""
        normals = self.sums.totals[:, _NORMAL]
        return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)

    @cached_property
    def sigmas(self) -> NDArray[np.float64]:
        """(n,) [m] standard deviation of the mean points."""
        return self.sums.totals[:, _WEIGHT] ** -0.5

    @cached_property
    def slopes(self) -> NDArray[np.float64]:
        """(n,) [rad²] variance of the normals about each direction within the surface."""
        return self.sums.totals[:, _SLOPE] / self.sums.totals[:, _WEIGHT] ** 2

    @cached_property
    def unevenness(self) -> NDArray[np.float64]:
        """(n,) [m²] variance of the mean points across the surface, as their neighbours show it."""
        return self.sums.totals[:, _UNEVENNESS] / self.sums.totals[:, _WEIGHT] ** 2

    @cached_property
    def planes(self) -> _native.PlaneMap:
        """The points with their normals, to fit scans to."""
        return _native.PlaneMap(
            self.points_xyz, self.normals_xyz, self.sigmas, self.slopes, self.unevenness, CELL
        )

    def nearest(
        self, points_xyz: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """For each point the nearest of the map.

        Args:
            points_xyz: (n, 3) [m] map frame.

        Returns:
            (n,) indices, and (n,) distances [m].
        """
        indices, squares = self._tree.batch_knn_search(points_xyz, 1)
        return np.asarray(indices, np.int64).ravel(), np.sqrt(np.asarray(squares).ravel())

    @cached_property
    def _tree(self) -> KdTree:
        from small_gicp import KdTree

        return KdTree(self.points_xyz)
