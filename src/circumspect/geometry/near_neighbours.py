"""Nearest neighbours within a reach that the density of the points itself sets."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

# Up to so many points all distances at once are quicker than a tree (and than importing one).
_DENSE_LIMIT = 4096
_BLOCK_SIZE = 2**16
_ROUNDING = 1e-13

# The spacing of points is the median distance to this neighbour. The nearest one will not do: on
# thin walls it is the point on the other side, and the median would be the thickness of the wall.
SPACING_RANK = 3

# Start and end of directed pairs, grouped by start, their distance, and the reach.
_Pairs = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], float]


def nearest_within_reach(
    points_xyz: NDArray[np.float64], neighbours: int, reach: float
) -> tuple[NDArray[np.int64], float]:
    """The nearest neighbours of each point, as far as they lie within reach.

    Args:
        points_xyz: (n, 3) points of an extent near 1, n >= 2.
        neighbours: How many neighbours to keep at most.
        reach: In spacings: medians of the distance to neighbour number `SPACING_RANK`.

    Returns:
        (n, neighbours) indices, each row filled up with -1, in no particular order; and the reach
        as a distance.
    """
    pairs = _pairs_dense if len(points_xyz) <= _DENSE_LIMIT else _pairs_tree
    start, end, distance, longest = pairs(points_xyz, neighbours, reach)
    amount = np.bincount(start, minlength=len(points_xyz))
    # Only where there are more than asked for does their order matter.
    crowded = np.flatnonzero(amount[start] > neighbours)
    nearest_first = np.lexsort((distance[crowded], start[crowded]))
    end[crowded] = end[crowded[nearest_first]]
    rank = np.arange(len(start)) - (np.cumsum(amount) - amount)[start]
    near = rank < neighbours
    table = np.full((len(points_xyz), neighbours), -1, dtype=np.int64)
    table[start[near], rank[near]] = end[near]
    return table, longest


def distances(
    points_xyz: NDArray[np.float64], start: NDArray[np.int64], end: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(m,) distances between points given by their indices."""
    squares = np.zeros(len(start))
    for axis in np.ascontiguousarray(points_xyz.T):
        offsets = axis[start] - axis[end]
        offsets *= offsets
        squares += offsets
    return np.sqrt(squares, out=squares)


def _pairs_dense(points: NDArray[np.float64], neighbours: int, reach: float) -> _Pairs:  # noqa: ARG001
    """All directed pairs within reach, from all squared distances, a block of rows at a time."""
    count = len(points)
    ranked = np.concatenate([_ranked_column(block) for _, block in _squared_distances(points)])
    longest = reach * float(np.median(distances(points, np.arange(count), ranked)))
    # The blocks are rounded; the exact distance decides.
    near = np.concatenate(
        [
            first * count + np.flatnonzero(block <= longest**2 + _ROUNDING)
            for first, block in _squared_distances(points)
        ]
    )
    start, end = np.divmod(near, count)
    return _within(points, start, end, longest)


def _ranked_column(block: NDArray[np.float64]) -> NDArray[np.int64]:
    """For each row the column of its smallest number but `SPACING_RANK` - 1; spoils the block."""
    rows = np.arange(len(block))
    for _ in range(min(SPACING_RANK, block.shape[1] - 1) - 1):
        block[rows, block.argmin(axis=1)] = np.inf
    return block.argmin(axis=1)


def _squared_distances(points: NDArray[np.float64]) -> Iterator[tuple[int, NDArray[np.float64]]]:
    """Blocks of rows of the table of squared distances, infinite from a point to itself.

    |a - b|² = |a|² - 2ab + |b|² is one product of (n, 5) matrices. The blocks stay in the cache
    and below the size at which BLAS would start threads; each is overwritten by the next.
    """
    centred = points - points.mean(axis=0)
    squares = np.einsum("nx,nx->n", centred, centred)[:, None]
    ones = np.ones_like(squares)
    left, right = np.hstack([squares, -2 * centred, ones]), np.hstack([ones, centred, squares]).T
    rows = max(1, _BLOCK_SIZE // len(points))
    buffer = np.empty((rows, len(points)))
    for first in range(0, len(points), rows):
        chosen = left[first : first + rows]
        block = np.matmul(chosen, right, out=buffer[: len(chosen)])
        block.flat[first :: len(points) + 1] = np.inf
        yield first, block


def _pairs_tree(points: NDArray[np.float64], neighbours: int, reach: float) -> _Pairs:
    """Directed pairs of nearest neighbours within reach, from a k-d tree."""
    from scipy.spatial import KDTree

    asked = max(neighbours, SPACING_RANK) + 1  # Each point is its own nearest one.
    nearest, indices = KDTree(points).query(points, asked)
    longest = reach * float(np.median(nearest[:, min(SPACING_RANK, len(points) - 1)]))
    start = np.repeat(np.arange(len(points)), asked)
    end = indices.ravel()
    valid = (end != start) & (end < len(points))
    return _within(points, start[valid], end[valid], longest)


def _within(
    points: NDArray[np.float64], start: NDArray[np.int64], end: NDArray[np.int64], longest: float
) -> _Pairs:
    distance = distances(points, start, end)
    kept = distance <= longest
    return start[kept], end[kept], distance[kept], longest
