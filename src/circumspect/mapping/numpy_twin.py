"""Every native kernel of mapping again in NumPy, written to be obviously right."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.mapping.linear_fit import (
    AVERTED,
    FAR,
    FEWEST,
    LEAST_SPREAD,
    STANDING,
    TELLING,
    TUKEY,
    LinearFit,
    Weighing,
)
from circumspect.mapping.scan import Scan
from circumspect.mapping.scan_surface import FLOOR
from circumspect.mapping.scene_map import SceneMap


def linearised(
    scan: Scan,
    scene: SceneMap,
    T: NDArray[np.float64],
    reach: float,
    weighing: Weighing = TELLING,
) -> LinearFit:
    """Twin of `linear_fit.linearised`."""
    from scipy.spatial import KDTree

    if len(scan) == 0 or len(scene) == 0:
        return LinearFit()
    R, t = T[:3, :3], T[:3, 3]
    placed = scan.points_xyz @ R.T + t
    sight = scene.points_xyz - t
    away = np.einsum("ij,ij->i", sight, scene.normals_xyz)
    shown = np.flatnonzero(away < AVERTED * np.linalg.norm(sight, axis=1))
    if len(shown) == 0:
        return LinearFit()
    found = KDTree(scene.points_xyz[shown]).query(placed)
    distances, indices = (np.asarray(values) for values in found)
    matched = np.flatnonzero(distances < reach)
    if len(matched) < FEWEST:
        return LinearFit()
    targets = shown[indices[matched]]
    normals = scene.normals_xyz[targets]
    r = np.einsum("ij,ij->i", placed[matched] - scene.points_xyz[targets], normals)
    sigma = np.hypot(scan.sigmas[matched], scene.sigmas[targets])
    u = r / sigma
    noise = max(LEAST_SPREAD, 1.4826 * float(np.median(np.abs(u))))
    belongs = _tukey(u, TUKEY * max(1.0, noise))
    variance = noise**2 + weighing.uneven * scene.unevenness[targets] / sigma**2
    cut = TUKEY * np.maximum(weighing.least_cut, np.sqrt(variance))
    weight = np.where(belongs > 0, _tukey(u, cut), 0) / (weighing.correlation * variance)
    # d r / d(φ, ρ) of T exp(φ, ρ): p × Rᵀn and Rᵀn, both in the optical frame.
    facing = normals @ R
    J = np.concatenate([np.cross(scan.points_xyz[matched], facing), facing], axis=1)
    J *= (1 / sigma)[:, None]
    weighted = J * weight[:, None]
    total = max(float(belongs.sum()), 1e-12)
    return LinearFit(
        weighted.T @ J,
        _feigned(
            scan.points_xyz[matched],
            facing,
            weight / sigma**2 * scene.slopes[targets],
        ),
        weighted.T @ u,
        int((belongs > 0).sum()),
        *_agreement(matched, np.abs(r), placed[:, 2]),
        float(np.sqrt((belongs * r**2).sum() / total)),
        float(np.sqrt((belongs * u**2).sum() / total)),
    )


def _tukey(u: NDArray[np.float64], cut: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Tukey's weights."""
    return np.clip(1 - (u / cut) ** 2, 0, None) ** 2


def _feigned(
    points_xyz: NDArray[np.float64], facing: NDArray[np.float64], factors: NDArray[np.float64]
) -> NDArray[np.float64]:
    """What noise of the normals adds to the Hessian: that of both directions across each."""
    total = np.zeros((6, 6))
    for point, normal, factor in zip(points_xyz, facing, factors, strict=True):
        cross = np.array([[0, -point[2], point[1]], [point[2], 0, -point[0]],
                          [-point[1], point[0], 0]])  # fmt: skip
        A = np.vstack([cross, np.eye(3)])
        total += factor * A @ (np.eye(3) - np.outer(normal, normal)) @ A.T
    return total


def _agreement(
    matched: NDArray[np.intp], r: NDArray[np.float64], height: NDArray[np.float64]
) -> tuple[float, float]:
    """Overlap and mean distance, by the points off the floor where there are enough."""
    standing = np.abs(height) > FLOOR
    if standing.sum() < STANDING:
        standing[:] = True
    near = np.zeros(len(height), bool)
    near[matched] = True
    distance = np.full(len(height), FAR)
    distance[matched] = np.minimum(r, FAR)
    return float(near[standing].mean()), float(distance[standing].mean())


def plane_fits(
    points_xyz: NDArray[np.float64], near: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Twin of `_native.plane_fits`."""
    around = points_xyz[near] - points_xyz[near].mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around) / near.shape[1])
    return vectors[:, :, 0], values
