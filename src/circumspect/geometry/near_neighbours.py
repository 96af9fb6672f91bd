"""Nearest neighbours within a reach that the density of the points itself sets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.spatial import KDTree

# Up to so many points all distances at once are quicker than a tree (and than importing one).
_DENSE_LIMIT = 4096
_BLOCK_SIZE = 2**16
_ROUNDING = 1e-13

# Points on several sheets that nearly coincide (thin walls, doubled faces) come in clusters, with a
# jump in the distances from the last neighbour in the cluster to the first one outside of it.
_LARGEST_CLUSTER = 6
_JUMP = 1.45  # More than the square root of 2, the largest one in a regular grid.
_SPACING_SAMPLE = 512

# Start and end of directed pairs, grouped by start, and their distance.
_Pairs = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]


def nearest_within_reach(
    points_xyz: NDArray[np.float64], neighbours: int, reach: float
) -> tuple[NDArray[np.int64], float]:
    """The nearest neighbours of each point, as far as they lie within reach.

    Args:
        points_xyz: (n, 3) points of an extent near 1, n >= 2.
        neighbours: How many neighbours to keep at most.
        reach: In spacings, see `spacing`.

    Returns:
        (n, neighbours) indices, each row filled up with -1, in no particular order; and the reach
        as a distance.
    """
    pairs = _pairs_dense if len(points_xyz) <= _DENSE_LIMIT else _pairs_tree
    longest = reach * spacing(points_xyz)
    start, end, distance = pairs(points_xyz, neighbours, longest)
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


def spacing(points_xyz: NDArray[np.float64]) -> float:
    """The typical distance from a point to the nearest one that is not in the same cluster.

    This is the median distance to the nearest neighbour, unless the medians to the second, third,
    … neighbour jump: then it is the one behind the last jump. On thin walls the nearest neighbour
    is the point on the other side, and its distance the thickness of the wall.

    Args:
        points_xyz: (n, 3) points of an extent near 1, n >= 2.
    """
    step = max(1, len(points_xyz) // _SPACING_SAMPLE)
    count = min(_LARGEST_CLUSTER, len(points_xyz) - 1)
    if len(points_xyz) <= _DENSE_LIMIT:
        nearest = _nearest_dense(points_xyz, step, count)
    else:
        nearest = _tree(points_xyz).query(points_xyz[::step], count + 1)[0][:, 1:]
    medians = np.median(nearest, axis=0)
    jumps = np.flatnonzero(medians[1:] > _JUMP * medians[:-1])
    return float(medians[jumps[-1] + 1 if len(jumps) else 0])


def _nearest_dense(points: NDArray[np.float64], step: int, count: int) -> NDArray[np.float64]:
    """(m, count) distances of every `step`-th point to its nearest neighbours, ascending."""
    chosen = np.arange(0, len(points), step)
    nearest = np.empty((len(chosen), count), dtype=np.int64)
    for first, block in _squared_distances(points, chosen):
        rows = np.arange(len(block))
        for rank in range(count):
            columns = block.argmin(axis=1)
            block[rows, columns] = np.inf
            nearest[first + rows, rank] = columns
    start = np.repeat(chosen, count)
    return distances(points, start, nearest.ravel()).reshape(nearest.shape)


def _pairs_dense(points: NDArray[np.float64], neighbours: int, longest: float) -> _Pairs:  # noqa: ARG001
    """All directed pairs within reach, from all squared distances."""
    count = len(points)
    # The blocks are rounded; the exact distance decides.
    near = [
        first * count + np.flatnonzero(block <= longest**2 + _ROUNDING)
        for first, block in _squared_distances(points, np.arange(count))
    ]
    start, end = np.divmod(np.concatenate(near), count)
    return _within(points, start, end, longest)


def _squared_distances(
    points: NDArray[np.float64], chosen: NDArray[np.int64]
) -> Iterator[tuple[int, NDArray[np.float64]]]:
    """Blocks of rows of the table of squared distances from the chosen points to all.

    |a - b|² = |a|² - 2ab + |b|² is one product of (n, 5) matrices. The blocks stay in the cache
    and below the size at which BLAS would start threads; each is overwritten by the next. The
    distance from a point to itself is infinite.

    Yields:
        The place of the first row in `chosen`, and the rows.
    """
    centred = points - points.mean(axis=0)
    squares = np.einsum("nx,nx->n", centred, centred)[:, None]
    ones = np.ones_like(squares)
    left, right = np.hstack([squares, -2 * centred, ones]), np.hstack([ones, centred, squares]).T
    rows = max(1, _BLOCK_SIZE // len(points))
    buffer = np.empty((rows, len(points)))
    for first in range(0, len(chosen), rows):
        some = chosen[first : first + rows]
        block = np.matmul(left[some], right, out=buffer[: len(some)])
        block[np.arange(len(some)), some] = np.inf
        yield first, block


def _pairs_tree(points: NDArray[np.float64], neighbours: int, longest: float) -> _Pairs:
    """Directed pairs of nearest neighbours within reach, from a k-d tree."""
    asked = neighbours + 1  # Each point is its own nearest one.
    _, indices = _tree(points).query(points, asked)
    start = np.repeat(np.arange(len(points)), asked)
    end = indices.ravel()
    valid = (end != start) & (end < len(points))
    return _within(points, start[valid], end[valid], longest)


def _tree(points: NDArray[np.float64]) -> KDTree:
    from scipy.spatial import KDTree

    return KDTree(points)


def _within(
    points: NDArray[np.float64], start: NDArray[np.int64], end: NDArray[np.int64], longest: float
) -> _Pairs:
    distance = distances(points, start, end)
    kept = distance <= longest
    return start[kept], end[kept], distance[kept]
