"""Surfaces from sparse points: near neighbours joined by small triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.triangle_mesh import TriangleMesh

NEIGHBOURS = 12
REACH = 1.9
# Up to so many points all distances at once are quicker than a tree (and than importing one).
_DENSE_LIMIT = 2048


def short_edge_triangles(
    points_xyz: ArrayLike, neighbours: int = NEIGHBOURS, reach: float = REACH
) -> TriangleMesh:
    """Join each point with pairs of its near neighbours where all three edges are short.

    The result covers the surface that evenly spread points (a Poisson-disk sample) lie on, without
    orientation, and with overlaps where neighbourhoods are not planar.

    Args:
        points_xyz: (n, 3) points.
        neighbours: How many nearest neighbours of a point may share a triangle with it.
        reach: The longest edge allowed, in medians of the distance to the nearest neighbour.

    Returns:
        The mesh of all such triangles, each once, over the given points.

    Raises:
        GeometryError: No three points lie near enough to each other.
    """
    points = np.asarray(points_xyz, dtype=np.float64)
    if neighbours < 2 or not reach > 0:
        raise InputError(f"neighbours must be at least 2 and reach positive: {neighbours}, {reach}")
    if len(points) < 3:
        raise GeometryError(f"{len(points)} points make no triangle; three are needed")
    find = _near_pairs_dense if len(points) <= _DENSE_LIMIT else _near_pairs_tree
    start, end, distance, longest = find(points, neighbours, reach)
    triangles = _closed_wedges(
        points, _ranked(start, end, distance, len(points), neighbours), longest
    )
    if len(triangles) == 0:
        raise GeometryError("no three points lie near enough to each other to join; raise `reach`")
    return TriangleMesh(points, triangles)


def fill_surface(
    cloud: PointCloud, per_triangle: int = 8, rng: np.random.Generator | int = 0
) -> PointCloud:
    """Close the holes between sparse points: add points on the triangles of near neighbours.

    The points given stay and keep their areas; the new ones stand for no area, so that the
    weighted centre does not move. They carry the normal of the corner that they lie nearest to.

    Args:
        cloud: n evenly spread points.
        per_triangle: How many points to draw in each triangle.
        rng: A generator or a seed.

    Returns:
        The points given, then the new ones; the cloud itself where no triangle can be made.
    """
    try:
        mesh = short_edge_triangles(cloud.points_xyz)
    except GeometryError:
        return cloud
    rng = np.random.default_rng(rng)
    corners = np.repeat(mesh.faces, per_triangle, axis=0)
    u, v = rng.random((2, len(corners)))
    fold = u + v > 1
    u, v = np.where(fold, 1 - u, u), np.where(fold, 1 - v, v)
    shares = np.stack([1 - u - v, u, v], axis=1)
    added = np.einsum("nc,ncx->nx", shares, cloud.points_xyz[corners])
    normals = None
    if cloud.normals_xyz is not None:
        nearest = corners[np.arange(len(corners)), shares.argmax(axis=1)]
        normals = np.concatenate([cloud.normals_xyz, cloud.normals_xyz[nearest]])
    return PointCloud(
        np.concatenate([cloud.points_xyz, added]),
        areas=np.concatenate(
            [cloud.weights if cloud.areas is None else cloud.areas, np.zeros(len(added))]
        ),
        normals_xyz=normals,
    )


_Pairs = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], float]


def _near_pairs_dense(points: NDArray[np.float64], neighbours: int, reach: float) -> _Pairs:  # noqa: ARG001
    """All directed pairs within reach, from the full table of squared distances."""
    count = len(points)
    centred = points - points.mean(axis=0)
    squares = np.einsum("nx,nx->n", centred, centred)[:, None]
    ones = np.ones_like(squares)
    # |a - b|² = |a|² - 2ab + |b|² as one product of (n, 5) matrices.
    table = np.hstack([squares, -2 * centred, ones]) @ np.hstack([ones, centred, squares]).T
    table.flat[:: count + 1] = np.inf
    nearest = _distances(points, np.arange(count), table.argmin(axis=1))
    longest = reach * float(np.median(nearest))
    # Rounding of the product is far below the slack; the exact distance decides.
    start, end = np.divmod(np.flatnonzero(table <= longest**2 + 1e-9 * float(squares.max())), count)
    return _within(points, start, end, longest)


def _near_pairs_tree(points: NDArray[np.float64], neighbours: int, reach: float) -> _Pairs:
    """Directed pairs of nearest neighbours within reach, from a k-d tree."""
    from scipy.spatial import KDTree

    distances, indices = KDTree(points).query(points, neighbours + 1)
    longest = reach * float(np.median(distances[:, 1]))
    start = np.repeat(np.arange(len(points)), neighbours + 1)
    end = indices.ravel()
    valid = (end != start) & (end < len(points))
    return _within(points, start[valid], end[valid], longest)


def _within(
    points: NDArray[np.float64], start: NDArray[np.int64], end: NDArray[np.int64], longest: float
) -> _Pairs:
    distance = _distances(points, start, end)
    kept = distance <= longest
    return start[kept], end[kept], distance[kept], longest


def _ranked(
    start: NDArray[np.int64],
    end: NDArray[np.int64],
    distance: NDArray[np.float64],
    count: int,
    neighbours: int,
) -> NDArray[np.int64]:
    """(count, neighbours) neighbours within reach, nearest first, -1 where there are no more."""
    order = np.lexsort((distance, start))
    start, end = start[order], end[order]
    first = np.searchsorted(start, np.arange(count))
    rank = np.arange(len(start)) - first[start]
    near = rank < neighbours
    table = np.full((count, neighbours), -1, dtype=np.int64)
    table[start[near], rank[near]] = end[near]
    return table


def _closed_wedges(
    points: NDArray[np.float64], table: NDArray[np.int64], longest: float
) -> NDArray[np.int64]:
    """Triangles of a point and two of its neighbours that lie within reach of each other."""
    one, other = np.triu_indices(table.shape[1], k=1)
    apex, wedge = np.nonzero(table[:, other] >= 0)  # Then `one`, which is nearer, exists too.
    left, right = table[apex, one[wedge]], table[apex, other[wedge]]
    closed = _distances(points, left, right) <= longest
    triangles = np.stack([apex[closed], left[closed], right[closed]], axis=1)
    triangles.sort(axis=1)
    return _unique_rows(triangles, len(points))


def _distances(
    points: NDArray[np.float64], start: NDArray[np.int64], end: NDArray[np.int64]
) -> NDArray[np.float64]:
    offsets = points.take(start, axis=0) - points.take(end, axis=0)
    return np.sqrt(np.einsum("nx,nx->n", offsets, offsets))


def _unique_rows(triangles: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Sorted rows without repetition, by one sort of whole numbers: (a * count + b) * count + c."""
    if count**3 > np.iinfo(np.int64).max:
        return np.unique(triangles, axis=0)
    keys = np.unique((triangles[:, 0] * count + triangles[:, 1]) * count + triangles[:, 2])
    pairs, last = np.divmod(keys, count)
    return np.stack([*np.divmod(pairs, count), last], axis=1)
