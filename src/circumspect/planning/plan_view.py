"""The object seen from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CELL = 0.02
"""Points in the same cell of this side [m] are one in plan view."""
KEY_BITS = 24
"""Of the number of a cell for y; the rest is for x."""
MOST_CELLS = 1 << 22
"""Cells are counted one by one where the box of all has at most so many."""
FILLS = 1.5
"""Voxels from 1 / FILLS of a cell's side on: of a level surface many cells have one point only."""
SOME = 20_000
"""So many points tell where the middle is."""
FEWEST = 8
"""Below so many points a shape is too thin to ignore any of them."""


def thinned(points: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """At most `most` of the points, evenly picked."""
    return points[:: max(1, -(-len(points) // most))]


def footprint(points_xyz: NDArray[np.float64], voxel: float = 0.0) -> NDArray[np.float64]:
    """(c, 2) [m] the middles of the plan-view cells in which the object has points.

    Of a larger object, cells with a single point are noise and left out, unless voxels are so
    large that one fills a cell.

    Args:
        points_xyz: (n, 3) [m].
        voxel: Side of the voxels that each have one of the points [m].
    """
    keys, counts = _counted(points_xyz)
    least = 2 if FILLS * voxel < CELL else 1
    if (counts >= least).sum() >= FEWEST:
        keys = keys[counts >= least]
    return cell_middles(keys, CELL)


def _counted(points_xyz: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Numbers of the cells that hold points, ascending, and how many each holds."""
    if len(points_xyz) == 0:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    # Column by column, without sorting: many times faster than `np.unique`.
    x, y = (np.floor(points_xyz[:, axis] / CELL) for axis in range(2))
    left, low = x.min(), y.min()
    width, depth = x.max() - left + 1, y.max() - low + 1
    if not width * depth <= MOST_CELLS:
        return np.unique(cell_keys(points_xyz[:, :2], CELL), return_counts=True)
    x -= left
    y -= low
    deep = int(depth)
    counts = np.bincount(x.astype(np.int32) * deep + y.astype(np.int32))
    full = np.flatnonzero(counts)
    return ((full // deep + int(left)) << KEY_BITS) + full % deep + int(low), counts[full]


def cell_keys(places_xy: NDArray[np.floating], side: float) -> NDArray[np.int64]:
    """(n,) one number for the cell of each (n, 2) place [m]; `side` is that of the cells [m]."""
    cells = np.floor(places_xy / side).astype(np.int64)
    return (cells[:, 0] << KEY_BITS) + cells[:, 1]


def cell_middles(keys: NDArray[np.int64], side: float) -> NDArray[np.float64]:
    """(n, 2) [m] the middles of cells given by their numbers."""
    x = (keys + (1 << (KEY_BITS - 1))) >> KEY_BITS
    return (np.stack([x, keys - (x << KEY_BITS)], axis=1).astype(np.float64) + 0.5) * side


def centre_of(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2,) [m] the middle of the plan view's bounding box, without the outermost percent."""
    flat = thinned(points, SOME)[:, :2]
    if len(flat) < 100:
        return (flat.min(axis=0) + flat.max(axis=0)) / 2
    low, high = np.quantile(flat, [0.01, 0.99], axis=0)
    return (low + high) / 2
