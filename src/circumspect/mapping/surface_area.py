"""How much surface each point of a model stands for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.voxel_sums import VoxelSums, patch_keys
from circumspect.mapping.frame_surface import FrameSurface

PATCH = 0.032
"""Side of the cells over which areas are summed [m]: many pixels a frame, even far away."""
COLUMNS = 2
"""Of the sums: area, frames."""


def frame_areas(surface: FrameSurface) -> VoxelSums:
    """Area that one frame shows of each patch, and a count of one.

    A patch is what of a cell's surface turns the same way, so that the two sides of a thin
    board, or the two faces at an edge, are counted each.
    """
    columns = np.stack([surface.areas, np.zeros_like(surface.areas)], axis=1)
    sums = VoxelSums.from_rows(patch_keys(surface.points_xyz, surface.normals_xyz, PATCH), columns)
    sums.totals[:, 1] = 1
    return sums


def several_frames_areas(
    points_xyz: NDArray[np.floating],
    normals_xyz: NDArray[np.floating],
    areas: NDArray[np.floating],
    frames: int,
) -> VoxelSums:
    """The same of points that several frames showed alike.

    Args:
        points_xyz: (n, 3) [m].
        normals_xyz: (n, 3).
        areas: (n,) [m²] that a frame showed of each.
        frames: How many there were.
    """
    columns = np.stack([frames * areas, np.zeros_like(areas)], axis=1)
    sums = VoxelSums.from_rows(patch_keys(points_xyz, normals_xyz, PATCH), columns)
    sums.totals[:, 1] = frames
    return sums


def point_areas(
    areas: VoxelSums, points_xyz: NDArray[np.floating], normals_xyz: NDArray[np.floating]
) -> NDArray[np.float64]:
    """Share the patches' areas out to points.

    A patch has the mean of the areas that frames showed of it: it counts no more for being seen
    often or from near. Its points have equal parts.

    Args:
        areas: Sums of `frame_areas` over frames.
        points_xyz: (n, 3) [m].
        normals_xyz: (n, 3) unit vectors.

    Returns:
        (n,) [m²].
    """
    # A point whose mean normal turns like none of its views has no patch, and no area.
    return areas.split_means(patch_keys(points_xyz, normals_xyz, PATCH))
