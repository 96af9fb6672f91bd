"""Evenly spread points of a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PointCloud, TriangleMesh, fill_surface
from circumspect.geometry.farthest_points import farthest_points

POINTS = 1024
CANDIDATES = 8 * POINTS


def evenly_sampled(mesh: TriangleMesh, seed: int = 0) -> NDArray[np.float32]:
    """Spread points evenly over a mesh, similar to Poisson disk sampling.

    Args:
        mesh: The surface.
        seed: Seed of the candidates.

    Returns:
        (1024, 3) points about their mean, in units of the longest side.

    Raises:
        GeometryError: The mesh has no area.
    """
    return _spread(mesh.sampled(CANDIDATES, seed).points_xyz)


def evenly_thinned(cloud: PointCloud, seed: int = 0) -> NDArray[np.float32]:
    """Spread points evenly over a cloud; sparse clouds are filled between near neighbours.

    Args:
        cloud: Points on the surface, which span a shape.
        seed: Seed of the candidates.

    Returns:
        (1024, 3) points about their mean, in units of the longest side.
    """
    if len(cloud) < CANDIDATES:
        cloud = fill_surface(cloud, CANDIDATES - len(cloud))
    chosen = np.random.default_rng(seed).choice(len(cloud), CANDIDATES, replace=False)
    return _spread(cloud.points_xyz[chosen])


def _spread(candidates: NDArray[np.float64]) -> NDArray[np.float32]:
    """(1024, 3) evenly spread points out of (m, 3) candidates."""
    candidates = candidates - candidates.mean(axis=0)
    candidates /= np.ptp(candidates, axis=0).max()
    return candidates[farthest_points(candidates, POINTS)].astype(np.float32)
