"""Scan-to-model registration: the pose from which a scan fits the scene best."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.mapping import se3
from circumspect.mapping.scan import Scan
from circumspect.mapping.scene_map import SceneMap

TUKEY = 4.685
"""Residuals of so many standard deviations have no say (95 % efficiency on normal noise)."""
CORRELATION = 14.0
"""So many points count as one independent measurement; see docs/derivations.md for how it is
measured."""
LEAST_SPREAD = 0.2
"""The noise is never taken for less than this share of what the sensor's description says."""
FLOOR = 0.05
"""What is within this height of z = 0 [m] may be floor, and floor looks the same everywhere."""
STANDING = 100
"""So many points off the floor are enough to tell the overlap by them alone."""
THINNED, COARSE = 3, 5.0
"""Every third point is enough until a step changes less than five times what ends the iteration."""
FAR = 0.02
"""A point this far [m] from the map's planes or further just does not fit."""
FEWEST = 6
"""Correspondences without which there is nothing to solve."""


@dataclass(frozen=True)
class RegistrationSettings:
    """How a scan is fitted.

    Attributes:
        reach: Points further than this [m] from the map have no correspondence.
        rounds: Most Gauss-Newton steps.
        turn, shift: Converged once a step changes less than this [rad], [m].
    """

    reach: float = 0.05
    rounds: int = 20
    turn: float = 2e-4
    shift: float = 2e-4


@dataclass(frozen=True, eq=False)
class Registration:
    """The outcome of `register`.

    Attributes:
        T_map_camera: The pose at the optimum of scan and prior together.
        hessian: (6, 6) information of the scan alone about changes of the pose (optical frame).
        information: (6, 6) that of the scan and the prior.
        innovation: (6,) change from the prior to the optimum.
        points: Of the scan.
        inliers: Points with a correspondence and a say.
        overlap: Share of the scan's points that have a correspondence; where enough of them
            stand off the floor, those alone are asked.
        distance: Mean distance of the same points to the map's planes [m], each at most `FAR`.
        residual: Root mean square distance of the inliers to the map's planes [m].
        misfit: The same in standard deviations of the noise; 1 is expected.
        iterations: Gauss-Newton steps taken.
        converged: The last step was small.
    """

    T_map_camera: RigidTransform
    hessian: NDArray[np.float64]
    information: NDArray[np.floating]
    innovation: NDArray[np.float64]
    points: int
    inliers: int
    overlap: float
    distance: float
    residual: float
    misfit: float
    iterations: int
    converged: bool


@dataclass(frozen=True, eq=False)
class _Fit:
    """The point-to-plane problem, linear about one pose."""

    hessian: NDArray[np.float64] = field(default_factory=lambda: np.zeros((6, 6)))
    gradient: NDArray[np.float64] = field(default_factory=lambda: np.zeros(6))
    inliers: int = 0
    overlap: float = 0.0
    distance: float = FAR
    residual: float = 0.0
    misfit: float = 0.0


def register(
    scan: Scan,
    scene: SceneMap,
    T_map_prior: RigidTransform,
    prior_information: NDArray[np.floating],
    settings: RegistrationSettings | None = None,
) -> Registration:
    """Fit a scan to the scene, held by a prior.

    Minimises Σ ρ(rᵢ / σᵢ) / c + ‖log(T_prior⁻¹ T)‖²_Λ over T by Gauss-Newton with Tukey's ρ, where
    rᵢ = nᵢ · (T pᵢ - qᵢ) is the distance of point pᵢ to the plane (qᵢ, nᵢ) of its nearest point in
    the map (Chen and Medioni 1991), σᵢ the noise of both, c `CORRELATION`, Λ `prior_information`.

    Args:
        scan: The frame's points.
        scene: What they are fitted to.
        T_map_prior: Where the camera is believed to be; the iteration starts there.
        prior_information: (6, 6) inverse covariance of that belief, in changes of the optical
            frame.
        settings: How.

    Returns:
        The optimum; where too few points have a correspondence, the prior, not converged.
    """
    s = settings or RegistrationSettings()
    change, T = np.zeros(6), T_map_prior
    fit, steps, converged = _Fit(), 0, False
    # The way is found with few points, the end with all of them.
    part = scan.thinned(THINNED)
    while steps < s.rounds:
        steps += 1
        fit = _linearised(part, scene, T, s.reach)
        if fit.inliers < FEWEST:
            change, T = np.zeros(6), T_map_prior
            break
        gradient = fit.gradient + prior_information @ change
        delta = -np.linalg.solve(fit.hessian + prior_information + 1e-9 * np.eye(6), gradient)
        T = T * se3.exp(delta)
        change = se3.log(T_map_prior.inv() * T)
        turn, shift = np.linalg.norm(delta.reshape(2, 3), axis=1)
        small = turn < s.turn and shift < s.shift
        smallish = turn < COARSE * s.turn and shift < COARSE * s.shift
        # Correspondences that flicker keep the last steps from vanishing.
        if part is scan and (small or (smallish and steps >= s.rounds // 2)):
            converged = True
            break
        if smallish:
            part = scan
    return Registration(
        T_map_camera=T,
        hessian=fit.hessian,
        information=fit.hessian + prior_information,
        innovation=change,
        points=len(scan),
        inliers=fit.inliers,
        overlap=fit.overlap,
        distance=fit.distance,
        residual=fit.residual,
        misfit=fit.misfit,
        iterations=steps,
        converged=converged,
    )


def _linearised(scan: Scan, scene: SceneMap, T: RigidTransform, reach: float) -> _Fit:
    if len(scan) == 0 or len(scene) == 0:
        return _Fit()
    matrix = T.as_matrix()
    R, t = matrix[:3, :3], matrix[:3, 3]
    placed = scan.points_xyz @ R.T + t
    indices, distances = scene.nearest(placed)
    matched = np.flatnonzero(distances < reach)
    if len(matched) < FEWEST:
        return _Fit()
    targets = indices[matched]
    normals = scene.normals_xyz[targets]
    r = np.einsum("ij,ij->i", placed[matched] - scene.points_xyz[targets], normals)
    sigma = np.hypot(scan.sigmas[matched], scene.sigmas[targets])
    u = r / sigma
    # The description of the sensor bounds what counts as an outlier; the residuals themselves
    # tell the noise, which averaging made smaller.
    noise = max(LEAST_SPREAD, 1.4826 * float(np.median(np.abs(u))))
    weight = np.clip(1 - (u / (TUKEY * max(1.0, noise))) ** 2, 0, None) ** 2
    # d r / d(φ, ρ) of T exp(φ, ρ): p × Rᵀn and Rᵀn, both in the optical frame.
    facing = normals @ R
    J = np.concatenate([np.cross(scan.points_xyz[matched], facing), facing], axis=1)
    J *= (1 / sigma)[:, None]
    weighted = J * (weight / (CORRELATION * noise**2))[:, None]
    say = weight > 0
    total = max(float(weight.sum()), 1e-12)
    return _Fit(
        weighted.T @ J,
        weighted.T @ u,
        int(say.sum()),
        *_agreement(matched, np.abs(r), placed[:, 2]),
        float(np.sqrt((weight * r**2).sum() / total)),
        float(np.sqrt((weight * u**2).sum() / total)),
    )


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
