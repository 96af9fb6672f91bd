"""Conversion of polygons and triangle strips to triangles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError


def fan_triangles(polygons: NDArray[np.number], vertex_count: int) -> NDArray[np.int64]:
    """Cut polygons of equally many corners into fans of triangles.

    Args:
        polygons: (m, k) indices of vertices; fewer than 3 corners give no triangle.
        vertex_count: How many vertices there are.

    Returns:
        (m * (k - 2), 3) indices.

    Raises:
        GeometryError: An index that is no whole number or names no vertex.
    """
    inside = (polygons >= 0) & (polygons < vertex_count)
    if not inside.all():
        worst = polygons[~inside].flat[0]
        raise GeometryError(
            f"a face names vertex {worst:g}, but the vertices are 0 … {vertex_count - 1}"
        )
    indices = polygons.astype(np.int64)
    if not np.array_equal(indices, polygons):
        raise GeometryError("a face names a vertex by a number that is not whole")
    corners = indices.shape[1]
    if corners < 3:
        return np.empty((0, 3), dtype=np.int64)
    triangles = np.empty((len(indices), corners - 2, 3), dtype=np.int64)
    triangles[:, :, 0] = indices[:, :1]
    triangles[:, :, 1] = indices[:, 1:-1]
    triangles[:, :, 2] = indices[:, 2:]
    return triangles.reshape(-1, 3)


def fan_triangles_mixed(
    polygons: Iterable[Sequence[float] | NDArray[np.number]], vertex_count: int
) -> NDArray[np.int64]:
    """`fan_triangles` of polygons with different numbers of corners, grouped by that number.

    Raises:
        GeometryError: An index that is no whole number or names no vertex.
    """
    by_corners: dict[int, list[Sequence[float] | NDArray[np.number]]] = {}
    for polygon in polygons:
        by_corners.setdefault(len(polygon), []).append(polygon)
    groups = [
        fan_triangles(np.asarray(group, dtype=np.float64), vertex_count)
        for corners, group in by_corners.items()
        if corners > 0
    ]
    return np.concatenate(groups) if groups else np.empty((0, 3), dtype=np.int64)


def strip_triangles(indices: NDArray[Any], restart: int | None = None) -> NDArray[Any]:
    """The triangles of a strip: each corner from the third on makes one with the two before.

    Every second triangle is reversed, so that all have the same orientation. Degenerate triangles,
    which join strips, are left out.

    Args:
        indices: (n,) vertices of the strip.
        restart: The index that ends one strip and begins the next; None if there is none.

    Returns:
        (f, 3) indices in the type given.
    """
    if restart is None:
        strips = [indices]
    else:
        strips = np.split(indices, np.flatnonzero(indices == restart))
        strips = [strip[strip != restart] for strip in strips]
    return np.concatenate([np.empty((0, 3), indices.dtype), *map(_of_one_strip, strips)])


def fan_of(indices: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles of a fan: the first corner with each pair of neighbours behind it.

    Args:
        indices: (n,) vertices of the fan.

    Returns:
        (n - 2, 3) indices; none for fewer than 3 vertices.
    """
    if len(indices) < 3:
        return np.empty((0, 3), np.int64)
    first = np.full(len(indices) - 2, indices[0], np.int64)
    return np.stack([first, indices[1:-1], indices[2:]], axis=1)


def _of_one_strip(indices: NDArray[Any]) -> NDArray[Any]:
    if len(indices) < 3:
        return np.empty((0, 3), indices.dtype)
    triangles = np.stack([indices[:-2], indices[1:-1], indices[2:]], axis=1)
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (a != c)]
