"""The plane that an object stands on, in a cloud that holds both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MAX_TILT = np.deg2rad(30.0)
"""Between the plane's normal and the given up direction."""
MAX_BELOW_SHARE = 0.02
"""Of the surface may lie below the plane: strays and reflections."""
MIN_FLOOR_SHARE = 0.05
"""Of the surface lies in the plane."""

_CELLS_ACROSS = 48
"""The cloud is thinned to so many cells along its diagonal, so that dense parts do not outvote."""
_COARSE = 0.015
"""Distance from the plane that counts as in it, in units of the diagonal."""
_NEIGHBOURS = 12
_HYPOTHESES = 400
_REFINEMENTS = 3
_MAX_RESIDUALS = 50_000


@dataclass(frozen=True)
class SupportingPlane:
    """A plane with nearly the whole cloud on one side.

    Attributes:
        normal_xyz: (3,) unit vector to the side of the object.
        offset: Distance of the plane from the origin along the normal, in the cloud's unit.
        tolerance: Points nearer to the plane than this lie in it.
        share: Of the cloud's surface that lies in it, 0 … 1.
    """

    normal_xyz: NDArray[np.float64]
    offset: float
    tolerance: float
    share: float

    def heights(self, points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) signed distances of points from the plane."""
        return points_xyz @ self.normal_xyz - self.offset


def find_supporting_plane(
    points_xyz: NDArray[np.float64],
    up_xyz: NDArray[np.float64] | None = None,
    rng: np.random.Generator | int = 0,
) -> SupportingPlane | None:
    """Find the largest plane that has nearly all other points on one side.

    Hypotheses are planes through single points with the normals of their neighbourhoods (RANSAC
    with one point); the best is refined by least squares over its inliers.

    Args:
        points_xyz: (n, 3).
        up_xyz: (3,) the direction that the normal is near to; None for any direction.
        rng: A generator or a seed.

    Returns:
        The plane; None where no large one has the cloud on one side.
    """
    cells, diagonal = thinned(points_xyz)
    if len(cells) < 4 * _NEIGHBOURS:
        return None
    rng = np.random.default_rng(rng)
    chosen = rng.permutation(len(cells))[:_HYPOTHESES]
    normals = _local_normals(cells, chosen)
    if up_xyz is not None:
        normals[normals @ up_xyz < 0] *= -1
        steep = normals @ up_xyz > np.cos(MAX_TILT)
        chosen, normals = chosen[steep], normals[steep]
    else:
        # Each side of a plane may be the object's.
        chosen, normals = np.tile(chosen, 2), np.concatenate([normals, -normals])
    coarse = _COARSE * diagonal
    best, best_score = None, MIN_FLOOR_SHARE * len(cells)
    for start, normal in zip(cells[chosen], normals, strict=True):
        heights = (cells - start) @ normal
        score = int((np.abs(heights) < coarse).sum())
        below = int((heights < -coarse).sum())
        if below <= MAX_BELOW_SHARE * len(cells) and score > best_score:
            best, best_score = (normal, float(start @ normal)), score
    if best is None:
        return None
    step = max(1, len(points_xyz) // _MAX_RESIDUALS)
    return _refined(cells, points_xyz[::step], *best, coarse)


def thinned(points_xyz: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """The mean of the points in each occupied cell of a grid, and the cloud's robust diagonal.

    Args:
        points_xyz: (n, 3).

    Returns:
        (m, 3) means, and the diagonal of the box that holds 98 % of the points along each axis.
    """
    some = points_xyz[:: max(1, len(points_xyz) // 200_000)]
    low, high = np.quantile(some, [0.01, 0.99], axis=0)
    diagonal = float(np.linalg.norm(high - low))
    if not diagonal > 0:
        return some[:1], 0.0
    near = some[(np.abs(some - (low + high) / 2) < 2 * diagonal).all(axis=1)]
    keys = np.floor((near - low) / (diagonal / _CELLS_ACROSS)).astype(np.int64)
    flat = np.ravel_multi_index(tuple((keys - keys.min(axis=0)).T), np.ptp(keys, axis=0) + 1)
    _, inverse, counts = np.unique(flat, return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(inverse, near[:, k]) / counts for k in range(3)], axis=1)
    return means, diagonal


def _local_normals(cells: NDArray[np.float64], chosen: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m, 3) normals of the neighbourhoods of the chosen cells."""
    # To load it takes longer than to read most files.
    from scipy.spatial import KDTree

    _, neighbours = KDTree(cells).query(cells[chosen], _NEIGHBOURS)
    patches = cells[neighbours]
    patches = patches - patches.mean(axis=1, keepdims=True)
    return np.linalg.svd(patches, full_matrices=False)[2][:, 2].copy()


def _refined(
    cells: NDArray[np.float64],
    points: NDArray[np.float64],
    normal: NDArray[np.float64],
    offset: float,
    coarse: float,
) -> SupportingPlane | None:
    """Least squares over the inliers, and a tolerance by their spread."""
    inliers = np.abs(cells @ normal - offset) < coarse
    for _ in range(_REFINEMENTS):
        if inliers.sum() < 3:
            return None
        centre = cells[inliers].mean(axis=0)
        axes = np.linalg.svd(cells[inliers] - centre, full_matrices=False)[2]
        normal = axes[2] * (1.0 if axes[2] @ normal > 0 else -1.0)
        offset = float(centre @ normal)
        inliers = np.abs(cells @ normal - offset) < coarse
    # The means of cells are less noisy than the points themselves.
    residuals = np.abs(points @ normal - offset)
    residuals = residuals[residuals < coarse]
    if len(residuals) == 0:
        return None
    spread = 1.4826 * float(np.median(residuals))
    tolerance = float(np.clip(3.0 * spread, 0.2 * coarse, coarse))
    share = float((np.abs(cells @ normal - offset) < tolerance).mean())
    return SupportingPlane(normal, offset, tolerance, share)
