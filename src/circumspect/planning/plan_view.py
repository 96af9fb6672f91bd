"""The object seen from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CELL = 0.02
"""Points in the same cell of this side [m] are one in plan view."""
FEWEST = 8
"""Below so many points a shape is too thin to ignore any of them."""


def thinned(points: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """At most `most` of the points, evenly picked."""
    return points[:: max(1, -(-len(points) // most))]


def footprint(points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """(c, 2) [m] the middles of the plan-view cells in which the object has points.

    Of a larger object, cells with a single point are noise and left out.
    """
    cells, counts = np.unique(
        np.floor(points_xyz[:, :2] / CELL).astype(np.int64), axis=0, return_counts=True
    )
    if (counts >= 2).sum() >= FEWEST:
        cells = cells[counts >= 2]
    return (cells.astype(np.float64) + 0.5) * CELL


def centre_of(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2,) [m] the middle of the plan view's bounding box, without the outermost percent."""
    flat = points[:, :2]
    if len(flat) < 100:
        return (flat.min(axis=0) + flat.max(axis=0)) / 2
    low, high = np.quantile(flat, [0.01, 0.99], axis=0)
    return (low + high) / 2
