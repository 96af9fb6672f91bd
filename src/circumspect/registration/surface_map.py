"""The surface map of the static scene, the target of scan registration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.voxel_sums import VoxelSums, patch_keys
from circumspect.registration import _native
from circumspect.registration.scan_surface import ScanSurface

if TYPE_CHECKING:
    from small_gicp import KdTree

MAX_BACKFACE_COSINE = 0.1
"""Map points are back faces if the cosine between normal and line of sight is larger than this.
They have no correspondence, so that the two sides of a thin board are not confused."""
SEARCH_CELL_M = 0.07
"""Side of the cells of the nearest-plane search [m], a little larger than the usual maximum
correspondence distance."""
# Columns of the sums: information of the point, weighted point (3), weighted normal (3), and
# normal variance and roughness, both with the squared weight.
_WEIGHT, _POINT, _NORMAL, _NORMAL_VARIANCE, _ROUGHNESS = 0, slice(1, 4), slice(4, 7), 7, 8
_COLUMNS = 9


@dataclass(frozen=True, eq=False)
class SurfaceMap:
    """Object, floor, walls and clutter as mean points with normals, map frame.

    Points are averaged per voxel and per signed axis nearest to the normal. The two sides of a thin
    board are therefore kept apart, even within one voxel. Maps are immutable; `with_surface`
    returns a new one.

    Attributes:
        voxel: Side of the voxels [m].
        sums: Sums over the scans, per voxel and axis.
    """

    voxel: float = 0.03
    sums: VoxelSums = field(default_factory=lambda: VoxelSums.empty(_COLUMNS))

    def __len__(self) -> int:
        return len(self.sums)

    def with_surface(self, surface: ScanSurface, T_map_camera: RigidTransform) -> SurfaceMap:
        """The map with one more scan.

        Args:
            surface: The scan with its normals.
            T_map_camera: Pose of the camera.
        """
        return self.with_surfaces([(surface, T_map_camera)])

    def with_surfaces(self, surfaces: Sequence[tuple[ScanSurface, RigidTransform]]) -> SurfaceMap:
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
            variances = np.column_stack([surface.normal_variances[known], surface.roughness[known]])
            columns.append(
                np.hstack([weights, weights * points, weights * normals, weights**2 * variances])
            )
        added = VoxelSums.from_rows(np.concatenate(keys), np.concatenate(columns))
        return SurfaceMap(self.voxel, self.sums.plus(added))

    @cached_property
    def points_xyz(self) -> NDArray[np.float64]:
        """(n, 3) [m] mean points."""
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
    def normal_variances(self) -> NDArray[np.float64]:
        """(n,) [rad²] variance of the mean normals' tilt about each tangent direction."""
        return self.sums.totals[:, _NORMAL_VARIANCE] / self.sums.totals[:, _WEIGHT] ** 2

    @cached_property
    def roughness(self) -> NDArray[np.float64]:
        """(n,) [m²] variance of the mean points across the surface, from the scans' roughness."""
        return self.sums.totals[:, _ROUGHNESS] / self.sums.totals[:, _WEIGHT] ** 2

    @cached_property
    def planes(self) -> _native.PlaneMap:
        """The points with their normals, indexed for registration."""
        return _native.PlaneMap(
            self.points_xyz,
            self.normals_xyz,
            self.sigmas,
            self.normal_variances,
            self.roughness,
            SEARCH_CELL_M,
        )

    def visible_nearest(
        self,
        points_xyz: NDArray[np.floating],
        camera_xyz: NDArray[np.floating],
        max_distance: float,
    ) -> NDArray[np.int64]:
        """The nearest map point of each given point that is visible from a camera.

        Args:
            points_xyz: (n, 3) [m] map frame.
            camera_xyz: (3,) [m] map frame.
            max_distance: Maximum distance to the map point [m].

        Returns:
            (n,) indices; -1 where there is none.
        """
        return self.planes.nearest(
            np.ascontiguousarray(points_xyz, np.float64),
            np.ascontiguousarray(camera_xyz, np.float64),
            max_distance,
            MAX_BACKFACE_COSINE,
        )

    def nearest(
        self, points_xyz: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The nearest map point of each given point.

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
