"""The object seen from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CELL = 0.02
"""Points in the same cell of this side [m] are one in plan view."""
KEY_BITS = 24
"""Of the number of a cell for y; the rest is for x."""
FEWEST = 8
"""Below so many points a shape is too thin to ignore any of them."""


def thinned(points: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """At most `most` of the points, evenly picked."""
    return points[:: max(1, -(-len(points) // most))]


def footprint(points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """(c, 2) [m] the middles of the plan-view cells in which the object has points.

    Of a larger object, cells with a single point are noise and left out.
    """
    keys, counts = np.unique(cell_keys(points_xyz[:, :2], CELL), return_counts=True)
    if (counts >= 2).sum() >= FEWEST:
        keys = keys[counts >= 2]
    return cell_middles(keys, CELL)


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
    flat = points[:, :2]
    if len(flat) < 100:
        return (flat.min(axis=0) + flat.max(axis=0)) / 2
    low, high = np.quantile(flat, [0.01, 0.99], axis=0)
    return (low + high) / 2
