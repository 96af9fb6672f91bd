"""The surface area that each point of a model represents.

Areas are summed per surface patch (`geometry.voxel_sums.patch_keys`), because single pixels are too
noisy. A patch has one of six orientations, so that the two sides of a thin board, or the two faces
at an edge, have separate areas.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.voxel_sums import VoxelSums, patch_keys
from circumspect.reconstruction.frame_surface import FrameSurface

PATCH_SIDE_M = 0.032
"""Side of the voxels that hold a patch [m]; a patch has many pixels even in distant views."""
COLUMNS = 2
"""Columns of the sums: area [m²], number of frames."""


def frame_areas(surface: FrameSurface) -> VoxelSums:
    """Visible area of each patch in one frame, with a frame count of one."""
    columns = np.stack([surface.areas, np.zeros_like(surface.areas)], axis=1)
    keys = patch_keys(surface.points_xyz, surface.normals_xyz, PATCH_SIDE_M)
    sums = VoxelSums.from_rows(keys, columns)
    sums.totals[:, 1] = 1
    return sums


def multi_frame_areas(
    points_xyz: NDArray[np.floating],
    normals_xyz: NDArray[np.floating],
    areas: NDArray[np.floating],
    frames: int,
) -> VoxelSums:
    """Area and frame count of each patch for points with equal areas in several frames.

    Args:
        points_xyz: (n, 3) [m].
        normals_xyz: (n, 3).
        areas: (n,) [m²] area of each point in one frame.
        frames: Number of frames.
    """
    columns = np.stack([frames * areas, np.zeros_like(areas)], axis=1)
    sums = VoxelSums.from_rows(patch_keys(points_xyz, normals_xyz, PATCH_SIDE_M), columns)
    sums.totals[:, 1] = frames
    return sums


def point_areas(
    areas: VoxelSums, points_xyz: NDArray[np.floating], normals_xyz: NDArray[np.floating]
) -> NDArray[np.float64]:
    """Distribute the areas of patches to points.

    The area of a patch is its mean over the frames that observed it, and therefore does not depend
    on the number of views or on their distance. The points of a patch get equal parts.

    Args:
        areas: Sums of `frame_areas` over frames.
        points_xyz: (n, 3) [m].
        normals_xyz: (n, 3) unit vectors.

    Returns:
        (n,) [m²]; 0 for a point whose mean normal has an orientation that no frame observed.
    """
    return areas.split_means(patch_keys(points_xyz, normals_xyz, PATCH_SIDE_M))
