"""Plan view of the object."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CELL_M = 0.02
"""Side of the cells [m]."""
KEY_BITS = 24
"""Number of bits of a cell number that encode y; the others encode x."""
MAX_CELLS = 1 << 22
"""Maximum number of cells of the bounding box for counting in an array."""
MAX_CELL_VOXEL_RATIO = 1.5
"""Voxels above 1 / this of a cell give one point for many cells of a level surface."""
MAX_CENTRE_POINTS = 20_000
"""Maximum number of points used for the centre."""
MIN_CELLS = 8
"""Minimum number of cells of a shape whose cells with a single point may be ignored."""


def thinned(points: NDArray[np.float64], max_points: int) -> NDArray[np.float64]:
    """At most `max_points` of the points, evenly chosen."""
    return points[:: max(1, -(-len(points) // max_points))]


def footprint(points_xyz: NDArray[np.float64], voxel: float = 0.0) -> NDArray[np.float64]:
    """(c, 2) centres of the plan-view cells that contain points of the object [m].

    Cells with a single point are noise and ignored, unless the object has few cells or its voxels
    are as large as cells.

    Args:
        points_xyz: (n, 3) [m].
        voxel: Side of the voxels, which have one point each [m].
    """
    keys, counts = _counted(points_xyz)
    min_count = 2 if MAX_CELL_VOXEL_RATIO * voxel < CELL_M else 1
    if (counts >= min_count).sum() >= MIN_CELLS:
        keys = keys[counts >= min_count]
    return cell_middles(keys, CELL_M)


def _counted(points_xyz: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Numbers of the occupied cells, ascending, and the number of points of each."""
    if len(points_xyz) == 0:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    # Without sorting, many times faster than `np.unique`.
    x, y = (np.floor(points_xyz[:, axis] / CELL_M) for axis in range(2))
    left, low = x.min(), y.min()
    width, depth = x.max() - left + 1, y.max() - low + 1
    if not width * depth <= MAX_CELLS:
        return np.unique(cell_keys(points_xyz[:, :2], CELL_M), return_counts=True)
    x -= left
    y -= low
    deep = int(depth)
    counts = np.bincount(x.astype(np.int32) * deep + y.astype(np.int32))
    full = np.flatnonzero(counts)
    return ((full // deep + int(left)) << KEY_BITS) + full % deep + int(low), counts[full]


def cell_keys(places_xy: NDArray[np.floating], side: float) -> NDArray[np.int64]:
    """(n,) numbers of the cells of (n, 2) positions [m]; `side` is the side of the cells [m]."""
    cells = np.floor(places_xy / side).astype(np.int64)
    return (cells[:, 0] << KEY_BITS) + cells[:, 1]


def cell_middles(keys: NDArray[np.int64], side: float) -> NDArray[np.float64]:
    """(n, 2) centres of cells given by their numbers [m]."""
    x = (keys + (1 << (KEY_BITS - 1))) >> KEY_BITS
    return (np.stack([x, keys - (x << KEY_BITS)], axis=1).astype(np.float64) + 0.5) * side


def centre_of(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2,) centre of the plan view's bounding box [m], without the outermost percent."""
    flat = thinned(points, MAX_CENTRE_POINTS)[:, :2]
    if len(flat) < 100:
        return (flat.min(axis=0) + flat.max(axis=0)) / 2
    low, high = np.quantile(flat, [0.01, 0.99], axis=0)
    return (low + high) / 2
