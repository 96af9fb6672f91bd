"""Registration of a scan to the surface map: point-to-plane ICP with a prior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import se3_matrices
from circumspect.geometry.composition import orthonormal
from circumspect.registration.point_to_plane import (
    COARSE,
    FINE,
    MIN_CORRESPONDENCES,
    PointToPlaneProblem,
    linearised,
)
from circumspect.registration.scan import Scan
from circumspect.registration.surface_map import SurfaceMap

COARSE_SCAN_STEP = 3
"""The coarse phase uses every n-th point."""
COARSE_TOLERANCE_FACTOR = 5.0
"""Multiple of the tolerances at which the coarse phase ends."""
NEGLIGIBLE_STEP_SIGMAS = 0.3
"""The coarse phase also ends at a step of fewer standard deviations of the optimum."""
SEARCH_SIGMAS = 1.0
"""Maximum correspondence distance of the coarse phase, in standard deviations of the prior's
position, if that is larger than the settings' distance."""
MAX_COARSE_DISTANCE_M = 0.15
"""Upper bound of the distance that follows from `SEARCH_SIGMAS` [m]."""
MIN_CONDITION = 1e-6
"""Eigenvalues of the Hessian below this fraction of the largest are taken as zero."""
MAX_CORRESPONDENCE_DISTANCE_M = 0.5
"""Upper bound of `RegistrationSettings.max_distance` [m]. The search visits cell by cell."""


@dataclass(frozen=True)
class RegistrationSettings:
    """Correspondences and convergence.

    Attributes:
        max_distance: Maximum correspondence distance [m], at most
            `MAX_CORRESPONDENCE_DISTANCE_M`.
        max_iterations: Maximum number of Gauss-Newton steps.
        rotation_tolerance: The iteration has converged at a step smaller than this [rad] …
        translation_tolerance: … and than this [m].

    Raises:
        InputError: `max_distance` is not positive or too large.
    """

    max_distance: float = 0.05
    max_iterations: int = 20
    rotation_tolerance: float = 2e-4
    translation_tolerance: float = 2e-4

    def __post_init__(self) -> None:
        if not 0 < self.max_distance <= MAX_CORRESPONDENCE_DISTANCE_M:
            raise InputError(
                f"max_distance must lie in 0 … {MAX_CORRESPONDENCE_DISTANCE_M:g} m, not "
                f"{self.max_distance:g}; relocalisation finds frames that are farther off"
            )


@dataclass(frozen=True, eq=False)
class Registration:
    """The result of `register`.

    Attributes:
        T_map_camera: The pose at the optimum of scan and prior together.
        hessian: (6, 6) information of the scan alone, for changes of the pose in the optical frame.
        information: (6, 6) information of scan and prior.
        gradient: (6,) gradient of the scan's cost alone at the optimum.
        innovation: (6,) change from the prior to the optimum.
        points: Number of points of the scan.
        inliers: Number of points with a correspondence and a positive weight.
        overlap: Fraction of the points that have a correspondence. Only points off the floor count
            if there are at least `MIN_POINTS_OFF_FLOOR`.
        distance: Mean distance of the same points to the map's planes [m], each limited to
            `MAX_PLANE_DISTANCE_M`.
        residual: Root mean square distance of the inliers to the map's planes [m].
        normalised_residual: The same in standard deviations of the sensor noise; 1 is expected.
        iterations: Number of Gauss-Newton steps.
        converged: Whether the last step was small.
    """

    T_map_camera: RigidTransform
    hessian: NDArray[np.float64]
    information: NDArray[np.floating]
    gradient: NDArray[np.float64]
    innovation: NDArray[np.float64]
    points: int
    inliers: int
    overlap: float
    distance: float
    residual: float
    normalised_residual: float
    iterations: int
    converged: bool

    @property
    def prior_information(self) -> NDArray[np.float64]:
        """(6, 6) information of the prior."""
        return self.information - self.hessian

    def measured(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The measurement of the scan alone, without the prior.

        The optimum of the scan alone is -H⁻¹g away from the joint optimum, with H the Hessian and g
        the gradient of the scan's cost.

        Returns:
            (4, 4) `T_map_camera`, equal to the joint optimum in directions that the scan does not
            determine, and (6, 6) its information H.
        """
        step = -self._inverse_hessian @ self.gradient
        return self.T_map_camera.as_matrix() @ se3_matrices.exp(step), self.hessian

    def squared_innovation(self) -> float:
        """Squared Mahalanobis distance between the optima of scan and prior.

        With the innovation δ, ν = δ - H⁻¹g and the prior's information Λ it is
        νᵀ(Λ⁻¹ + H⁻¹)⁻¹ν = δᵀΛδ + gᵀH⁻¹g, as g = -Λδ at the joint optimum. Directions that the scan
        does not determine add nothing.
        """
        of_prior = self.innovation @ self.prior_information @ self.innovation
        return float(of_prior + self.gradient @ self._inverse_hessian @ self.gradient)

    def log_occam_factor(self) -> float:
        """½ log |Λ| - ½ log |Λ + H|: logarithm of the Occam factor, at most 0.

        Laplace's approximation of the evidence for a prior is the likelihood at the joint optimum
        times this factor (MacKay, "Information Theory, Inference, and Learning Algorithms", 2003,
        chapter 28). A vague prior has a small factor: it explains almost any scan.
        """
        of_prior, of_both = (
            np.linalg.slogdet(matrix)[1] for matrix in (self.prior_information, self.information)
        )
        return min(float(of_prior - of_both) / 2, 0.0)

    @property
    def _inverse_hessian(self) -> NDArray[np.floating]:
        return np.linalg.pinv(self.hessian, rcond=MIN_CONDITION, hermitian=True)


def register(
    scan: Scan,
    surface_map: SurfaceMap,
    T_map_prior: RigidTransform,
    prior_information: NDArray[np.floating],
    settings: RegistrationSettings | None = None,
    T_map_start: RigidTransform | None = None,
) -> Registration:
    """Register a scan to the map, with a prior.

    Minimises Σ ρ(rᵢ / ςᵢ) / c + ½ ‖log(T_prior⁻¹ T)‖²_Λ over T by Gauss-Newton with Tukey's ρ.
    rᵢ = nᵢ · (T pᵢ - qᵢ) is the distance of point pᵢ to the plane (qᵢ, nᵢ) of its nearest point in
    the map (Chen and Medioni 1991). ςᵢ² is the variance of the noise of both, scaled to the
    residuals, plus that of the plane's roughness. c is `Scan.correlations` times the factor of
    `FINE`, Λ is `prior_information`. Directions with only spurious information are left to the
    prior.

    Args:
        scan: The scan.
        surface_map: The map.
        T_map_prior: Pose of the prior.
        prior_information: (6, 6) inverse covariance of the prior, for changes of the pose in the
            optical frame.
        settings: Correspondences and convergence.
        T_map_start: Initial pose of the iteration; None means the prior.

    Returns:
        The optimum; the prior, not converged, if too few points have a correspondence.
    """
    s = settings or RegistrationSettings()
    prior = T_map_prior.as_matrix()
    start = prior if T_map_start is None else T_map_start.as_matrix()
    solver = _GaussNewton(scan, surface_map, prior, np.asarray(prior_information), start)
    while solver.steps < s.max_iterations and not solver.finished:
        solver.step(s)
    problem = solver.problem
    return Registration(
        T_map_camera=orthonormal(solver.T) if solver.moved else T_map_prior,
        hessian=problem.hessian,
        information=problem.hessian + prior_information,
        gradient=problem.gradient + problem.hessian @ solver.last_step,
        innovation=solver.change,
        points=len(scan),
        inliers=problem.inliers,
        overlap=problem.overlap,
        distance=problem.distance,
        residual=problem.residual,
        normalised_residual=problem.normalised_residual,
        iterations=solver.steps,
        converged=solver.converged,
    )


class _GaussNewton:
    """Gauss-Newton iteration: a coarse phase with few points, then a fine one with all."""

    def __init__(
        self,
        scan: Scan,
        surface_map: SurfaceMap,
        prior: NDArray[np.float64],
        prior_information: NDArray[np.floating],
        start: NDArray[np.float64],
    ) -> None:
        self.T, self.problem = start, PointToPlaneProblem()
        self.last_step = np.zeros(6)
        self.steps = 0
        self.moved = self.converged = self.finished = False
        self._prior, self._inverse_prior = prior, se3_matrices.inverse(prior)
        self.change = se3_matrices.log(self._inverse_prior @ start)
        self._prior_information = prior_information
        self._scan, self._map = scan, surface_map
        self._points = scan.subsampled(COARSE_SCAN_STEP)
        variance = np.linalg.eigvalsh(np.linalg.inv(prior_information)[3:, 3:])[-1]
        self._coarse_distance = min(SEARCH_SIGMAS * float(variance) ** 0.5, MAX_COARSE_DISTANCE_M)

    def step(self, s: RegistrationSettings) -> None:
        """Take one step. Finishes if it is small, or if there are too few correspondences."""
        self.steps += 1
        coarse = self._points is not self._scan
        distance = max(s.max_distance, self._coarse_distance) if coarse else s.max_distance
        weighting = COARSE if coarse else FINE
        self.problem = linearised(
            self._points, self._map, self.T, distance, weighting
        ).without_spurious_information()
        if self.problem.inliers < MIN_CORRESPONDENCES:
            self.T, self.change = self._prior, np.zeros(6)
            self.last_step = np.zeros(6)
            self.moved, self.finished = False, True
            return
        gradient = self.problem.gradient + self._prior_information @ self.change
        information = self.problem.hessian + self._prior_information
        delta = -np.linalg.solve(information + 1e-9 * np.eye(6), gradient)
        self.T, self.last_step = self.T @ se3_matrices.exp(delta), delta
        self.change = se3_matrices.log(self._inverse_prior @ self.T)
        self.moved = True
        self._check_convergence(delta, information, s)

    def _check_convergence(
        self,
        delta: NDArray[np.floating],
        information: NDArray[np.floating],
        s: RegistrationSettings,
    ) -> None:
        # Alternating correspondences keep the last steps from vanishing. A step that is small
        # compared with the uncertainty is therefore accepted after half of the iterations.
        late = self.steps >= s.max_iterations // 2
        negligible = float(delta @ information @ delta) < NEGLIGIBLE_STEP_SIGMAS**2
        nearly = _is_small(delta, s, COARSE_TOLERANCE_FACTOR) or negligible
        if self._points is self._scan and (_is_small(delta, s) or (nearly and late)):
            self.converged = self.finished = True
        elif nearly or late:
            self._points = self._scan


def _is_small(
    delta: NDArray[np.floating], settings: RegistrationSettings, factor: float = 1.0
) -> bool:
    """Whether a step is within a multiple of the tolerances."""
    rotation, translation = np.linalg.norm(delta.reshape(2, 3), axis=1)
    return bool(
        rotation < factor * settings.rotation_tolerance
        and translation < factor * settings.translation_tolerance
    )
