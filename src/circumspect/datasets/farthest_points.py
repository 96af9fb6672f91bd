"""Evenly spread points of a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import TriangleMesh

POINTS = 1024
CANDIDATES = 8 * POINTS


def evenly_sampled(mesh: TriangleMesh, seed: int = 0) -> NDArray[np.float32]:
    """Spread points over a mesh so that none lie close together, much as a Poisson disk does.

    Args:
        mesh: The surface.
        seed: Of the candidates.

    Returns:
        (1024, 3) points about their mean, in units of the longest side.

    Raises:
        GeometryError: The mesh has no area.
    """
    candidates = mesh.sampled(CANDIDATES, seed).points_xyz
    candidates = candidates - candidates.mean(axis=0)
    candidates /= np.ptp(candidates, axis=0).max()
    return candidates[farthest_points(candidates, POINTS)].astype(np.float32)


def farthest_points(points_xyz: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Indices of points chosen one by one, each the farthest from those before it.

    Args:
        points_xyz: (n, 3), n >= count.
        count: How many to choose.

    Returns:
        (count,) indices.
    """
    chosen = np.zeros(count, np.int64)
    nearest = np.full(len(points_xyz), np.inf)
    for i in range(1, count):
        offset = points_xyz - points_xyz[chosen[i - 1]]
        np.minimum(nearest, np.einsum("ij,ij->i", offset, offset), out=nearest)
        chosen[i] = nearest.argmax()
    return chosen
