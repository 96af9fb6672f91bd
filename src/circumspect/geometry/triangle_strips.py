"""Strips and fans of triangles as single triangles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def strip_triangles(indices: NDArray[Any], restart: int | None = None) -> NDArray[Any]:
    """The triangles of a strip: each corner from the third on makes one with the two before.

    Every second triangle is turned over, so that all have the same orientation. Degenerate ones,
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
