"""NumPy reference of the kernels of registration, written for clarity; used by the tests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.registration.point_to_plane import (
    FINE,
    MAX_BACKFACE_COSINE,
    MAX_PLANE_DISTANCE_M,
    MIN_CORRESPONDENCES,
    MIN_NOISE_SCALE,
    MIN_POINTS_OFF_FLOOR,
    TUKEY_CUTOFF,
    PointToPlaneProblem,
    Weighting,
)
from circumspect.registration.scan import Scan
from circumspect.registration.scan_surface import MAX_FLOOR_HEIGHT_M
from circumspect.registration.surface_map import SurfaceMap


def linearised(
    scan: Scan,
    surface_map: SurfaceMap,
    T: NDArray[np.float64],
    max_distance: float,
    weighting: Weighting = FINE,
) -> PointToPlaneProblem:
    """Reference of `point_to_plane.linearised`."""
    from scipy.spatial import KDTree

    if len(scan) == 0 or len(surface_map) == 0:
        return PointToPlaneProblem()
    R, t = T[:3, :3], T[:3, 3]
    points = scan.points_xyz @ R.T + t
    sight = surface_map.points_xyz - t
    away = np.einsum("ij,ij->i", sight, surface_map.normals_xyz)
    visible = np.flatnonzero(away < MAX_BACKFACE_COSINE * np.linalg.norm(sight, axis=1))
    if len(visible) == 0:
        return PointToPlaneProblem()
    found = KDTree(surface_map.points_xyz[visible]).query(points)
    distances, indices = (np.asarray(values) for values in found)
    matched = np.flatnonzero(distances < max_distance)
    if len(matched) < MIN_CORRESPONDENCES:
        return PointToPlaneProblem()
    targets = visible[indices[matched]]
    normals = surface_map.normals_xyz[targets]
    r = np.einsum("ij,ij->i", points[matched] - surface_map.points_xyz[targets], normals)
    sigma = np.hypot(scan.sigmas[matched], surface_map.sigmas[targets])
    u = r / sigma
    noise = max(MIN_NOISE_SCALE, 1.4826 * float(np.median(np.abs(u))))
    inlier = _tukey(u, TUKEY_CUTOFF * max(1.0, noise))
    roughness = surface_map.roughness[targets]
    variance = noise**2 + weighting.roughness_factor * roughness / sigma**2
    cutoff = TUKEY_CUTOFF * np.maximum(weighting.min_cutoff, np.sqrt(variance))
    weight = np.where(inlier > 0, _tukey(u, cutoff), 0) / (
        weighting.correlation_factor * scan.correlations[matched] * variance
    )
    # d r / d(φ, ρ) of T exp(φ, ρ): p × Rᵀn and Rᵀn, both in the optical frame.
    facing = normals @ R
    J = np.concatenate([np.cross(scan.points_xyz[matched], facing), facing], axis=1)
    J *= (1 / sigma)[:, None]
    weighted = J * weight[:, None]
    total = max(float(inlier.sum()), 1e-12)
    return PointToPlaneProblem(
        weighted.T @ J,
        _spurious(
            scan.points_xyz[matched],
            facing,
            weight / sigma**2 * surface_map.normal_variances[targets],
        ),
        weighted.T @ u,
        int((inlier > 0).sum()),
        *_overlap_and_distance(matched, np.abs(r), points[:, 2]),
        float(np.sqrt((inlier * r**2).sum() / total)),
        float(np.sqrt((inlier * u**2).sum() / total)),
    )


def _tukey(u: NDArray[np.float64], cutoff: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Tukey's weights."""
    return np.clip(1 - (u / cutoff) ** 2, 0, None) ** 2


def _spurious(
    points_xyz: NDArray[np.float64], facing: NDArray[np.float64], factors: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Expected contribution of the normals' noise, in both tangent directions, to the Hessian."""
    total = np.zeros((6, 6))
    for point, normal, factor in zip(points_xyz, facing, factors, strict=True):
        cross = np.array([[0, -point[2], point[1]], [point[2], 0, -point[0]],
                          [-point[1], point[0], 0]])  # fmt: skip
        A = np.vstack([cross, np.eye(3)])
        total += factor * A @ (np.eye(3) - np.outer(normal, normal)) @ A.T
    return total


def _overlap_and_distance(
    matched: NDArray[np.intp], r: NDArray[np.float64], height: NDArray[np.float64]
) -> tuple[float, float]:
    """Overlap and mean distance of the points off the floor, or of all if there are too few."""
    counted = np.abs(height) > MAX_FLOOR_HEIGHT_M
    if counted.sum() < MIN_POINTS_OFF_FLOOR:
        counted[:] = True
    near = np.zeros(len(height), bool)
    near[matched] = True
    distance = np.full(len(height), MAX_PLANE_DISTANCE_M)
    distance[matched] = np.minimum(r, MAX_PLANE_DISTANCE_M)
    return float(near[counted].mean()), float(distance[counted].mean())


def plane_fits(
    points_xyz: NDArray[np.float64], neighbours: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Reference of `_native.plane_fits`."""
    near = points_xyz[neighbours]
    near = near - near.mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", near, near) / neighbours.shape[1])
    return vectors[:, :, 0], values
