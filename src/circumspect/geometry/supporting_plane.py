"""The plane that supports an object, in a cloud with both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MAX_TILT = np.deg2rad(30.0)
"""Largest angle between the plane's normal and the given up direction."""
MAX_BELOW_SHARE = 0.02
"""Fraction of the surface that may lie below the plane: outliers and reflections."""
MIN_FLOOR_SHARE = 0.05
"""Smallest fraction of the surface in the plane."""

_CELLS_ACROSS = 48
"""Cells along the cloud's diagonal to which it is thinned, so that dense parts do not dominate."""
_COARSE = 0.015
"""Distance of inliers from the plane, in units of the diagonal."""
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
        tolerance: Largest distance of inliers.
        share: Fraction of the cloud's surface in it, 0 … 1.
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
    with one point). The best one is refined by least squares over its inliers.

    Args:
        points_xyz: (n, 3).
        up_xyz: (3,) the approximate direction of the normal; None for any direction.
        rng: A generator or a seed.

    Returns:
        The plane; None if no large one has the cloud on one side.
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
        # The object may be on either side of a plane.
        chosen, normals = np.tile(chosen, 2), np.concatenate([normals, -normals])
    coarse = _COARSE * diagonal
    offsets = np.einsum("ij,ij->i", cells[chosen], normals)
    best = largest_with_all_above(
        cells, normals, offsets, coarse, coarse, MIN_FLOOR_SHARE * len(cells)
    )
    if best is None:
        return None
    step = max(1, len(points_xyz) // _MAX_RESIDUALS)
    return _refined(cells, points_xyz[::step], normals[best], float(offsets[best]), coarse)


def largest_with_all_above(
    points_xyz: NDArray[np.float64],
    normals_xyz: NDArray[np.float64],
    offsets: NDArray[np.float64],
    tolerance: float | NDArray[np.float64],
    below: float,
    min_inliers: float,
) -> int | None:
    """The hypothesis with the most inliers among those with nearly no point below.

    Args:
        points_xyz: (n, 3).
        normals_xyz: (m, 3) unit vectors, upwards.
        offsets: (m,) distances of the planes from the origin along their normals.
        tolerance: Largest distance of inliers, or (n,) one per point.
        below: Points further below a plane than this are not above it.
        min_inliers: The plane has more than this many.

    Returns:
        Its index, the first of equal ones; None without any.
    """
    best, most = None, min_inliers
    for number, (normal, offset) in enumerate(zip(normals_xyz, offsets, strict=True)):
        heights = points_xyz @ normal - offset
        inliers = int((np.abs(heights) < tolerance).sum())
        if inliers > most and (heights < -below).mean() <= MAX_BELOW_SHARE:
            best, most = number, inliers
    return best


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
    # Its import takes longer than reading most files.
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
    """Least squares over the inliers, with a tolerance from their spread."""
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
