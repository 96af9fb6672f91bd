"""Surfaces from sparse points: small triangles between near neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import _native
from circumspect.geometry.frozen_array import frozen, require_coordinates
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.triangle_mesh import TriangleMesh

# Enough to close the surface of a Poisson-disk sample, also with doubled sheets.
NEIGHBOURS = 16
REACH = 1.9


def short_edge_triangles(
    points_xyz: ArrayLike, neighbours: int = NEIGHBOURS, reach: float = REACH
) -> TriangleMesh:
    """Join each point with pairs of its near neighbours if all three edges are short.

    The result covers the surface of evenly spread points (a Poisson-disk sample), without
    orientation, and with overlaps if neighbourhoods are not planar.

    Args:
        points_xyz: (n, 3) points.
        neighbours: Number of nearest neighbours that may share a triangle with a point.
        reach: The longest edge, in units of the typical distance from a point to the nearest one on
            the same side of a thin wall.

    Returns:
        The mesh of all such triangles, each once, over the given points.

    Raises:
        GeometryError: No three points are near enough to each other.
        InputError: `neighbours` or `reach` are out of range.
    """
    points = frozen(points_xyz)
    require_coordinates(points, "points")
    if neighbours < 2 or not 0 < reach < np.inf:
        raise InputError(f"neighbours must be at least 2 and reach positive: {neighbours}, {reach}")
    distinct = _distinct(points)
    triangles = _short_edge_faces(points[distinct], neighbours, reach)
    if len(triangles) == 0:
        raise GeometryError("no three points lie near enough to each other to be joined")
    return TriangleMesh(points, distinct[triangles])


def fill_surface(
    cloud: PointCloud, count: int = 16_384, rng: np.random.Generator | int = 0
) -> PointCloud:
    """Close the holes between sparse points: add points on the triangles of near neighbours.

    The given points stay and keep their areas. The new ones have no area, so that the weighted
    centre does not move; their normal is that of the nearest corner.

    Args:
        cloud: n evenly spread points.
        count: Number of points to add, spread evenly over the area of all triangles.
        rng: A generator or a seed.

    Returns:
        The given points, then the new ones; the cloud itself if there are no triangles.
    """
    rng = np.random.default_rng(rng)
    try:
        mesh = short_edge_triangles(cloud.points_xyz)
        corners = mesh.faces[mesh.chosen_by_area(count, rng)]
    except GeometryError:
        return cloud
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


def _distinct(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Indices of the points without exact duplicates."""
    x, y, z = points.T
    keys = np.sort(x + np.e * y + np.pi * z)  # Points in one place have one key.
    if (np.diff(keys) > 0).all():
        return np.arange(len(points))
    return np.unique(points, axis=0, return_index=True)[1]


def _short_edge_faces(
    points: NDArray[np.float64], neighbours: int, reach: float
) -> NDArray[np.int64]:
    if len(points) < 3:
        return np.empty((0, 3), dtype=np.int64)
    scaled = (points - points[0]) / float(np.ptp(points, axis=0).max())
    return _native.short_edge_faces(scaled, min(neighbours, len(points)), reach)
