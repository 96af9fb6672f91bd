"""Evenly spread points of a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import TriangleMesh
from circumspect.geometry.farthest_points import farthest_points

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
