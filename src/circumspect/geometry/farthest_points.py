"""Farthest point sampling: points that cover a cloud evenly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def farthest_points(
    points_xyz: NDArray[np.floating], count: int, first: int = 0
) -> NDArray[np.int64]:
    """Indices of a farthest point sample: each point is the farthest from those before it.

    Every prefix of the result is the farthest point sample of that many points, of the whole cloud
    and of every longer prefix. Ties choose the first point.

    Args:
        points_xyz: (n, 3), n >= count.
        count: How many to choose.
        first: Index of the point to begin with.

    Returns:
        (count,) distinct indices.
    """
    x, y, z = np.ascontiguousarray(points_xyz.T)
    chosen = np.empty(count, np.int64)
    nearest = np.full(len(x), np.inf, x.dtype)
    at = first
    for i in range(count):
        chosen[i] = at
        # This order of the axes equals the sum of a row, bit for bit.
        away = np.square(x - x[at]) + np.square(z - z[at]) + np.square(y - y[at])
        np.minimum(nearest, away, out=nearest)
        # A copy of a chosen point has distance 0; the point itself is no longer a candidate.
        nearest[at] = -1.0
        at = int(nearest.argmax())
    return chosen
