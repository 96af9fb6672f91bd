"""Scan-to-model registration: the pose from which a scan fits the scene best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import se3_matrices
from circumspect.mapping.linear_fit import FEWEST, FINDING, TELLING, LinearFit, linearised
from circumspect.mapping.scan import Scan
from circumspect.mapping.scene_map import SceneMap

THINNED, COARSE = 3, 5.0
"""Every third point is enough until a step changes less than five times what ends the iteration."""

MEANT = 0.3
"""A step of fewer standard deviations of the outcome is smallish, too."""
UNCERTAIN, FARTHEST_REACH = 1.0, 0.15
"""At first correspondences are looked for as far as the prior's place is uncertain, in standard
deviations, up to this distance [m]."""
LONGEST_REACH = 0.5
"""Of correspondences [m]."""


@dataclass(frozen=True)
class RegistrationSettings:
    """How a scan is fitted.

    Attributes:
        reach: Points further than this [m] from the map have no correspondence; at most
            `LONGEST_REACH`, for what lies within it is searched cell by cell.
        rounds: Most Gauss-Newton steps.
        turn, shift: Converged once a step changes less than this [rad], [m].

    Raises:
        InputError: A reach that is not positive, or too long.
    """

    reach: float = 0.05
    rounds: int = 20
    turn: float = 2e-4
    shift: float = 2e-4

    def __post_init__(self) -> None:
        if not 0 < self.reach <= LONGEST_REACH:
            raise InputError(
                f"the reach must lie in 0 … {LONGEST_REACH:g} m, not {self.reach:g}; frames that "
                "are farther off are placed by relocalisation"
            )


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


def register(
    scan: Scan,
    scene: SceneMap,
    T_map_prior: RigidTransform,
    prior_information: NDArray[np.floating],
    settings: RegistrationSettings | None = None,
) -> Registration:
    """Fit a scan to the scene, held by a prior.

    Minimises Σ ρ(rᵢ / ςᵢ) / c + ½ ‖log(T_prior⁻¹ T)‖²_Λ over T by Gauss-Newton with Tukey's ρ,
    where rᵢ = nᵢ · (T pᵢ - qᵢ) is the distance of point pᵢ to the plane (qᵢ, nᵢ) of its nearest
    point in the map (Chen and Medioni 1991), ςᵢ² the variance of the noise of both, as much of it
    as the residuals show, and of what the plane itself is off by, c `TELLING.correlation`, Λ
    `prior_information`. Directions that only the normals' noise holds are left to the prior.

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
    descent = _Descent(scan, scene, T_map_prior.as_matrix(), np.asarray(prior_information))
    while descent.steps < s.rounds and not descent.over:
        descent.step(s)
    fit = descent.fit
    return Registration(
        T_map_camera=RigidTransform.from_matrix(descent.T) if descent.moved else T_map_prior,
        hessian=fit.hessian,
        information=fit.hessian + prior_information,
        innovation=descent.change,
        points=len(scan),
        inliers=fit.inliers,
        overlap=fit.overlap,
        distance=fit.distance,
        residual=fit.residual,
        misfit=fit.misfit,
        iterations=descent.steps,
        converged=descent.converged,
    )


class _Descent:
    """Gauss-Newton from the prior on; the way is found with few points, the end with all."""

    def __init__(
        self,
        scan: Scan,
        scene: SceneMap,
        prior: NDArray[np.float64],
        prior_information: NDArray[np.floating],
    ) -> None:
        self.T, self.change, self.fit = prior, np.zeros(6), LinearFit()
        self.steps = 0
        self.moved = self.converged = self.over = False
        self._prior, self._back = prior, se3_matrices.inverse(prior)
        self._held = prior_information
        self._scan, self._scene, self._part = scan, scene, scan.thinned(THINNED)
        place = float(np.linalg.eigvalsh(np.linalg.inv(self._held)[3:, 3:])[-1]) ** 0.5
        self._far = min(UNCERTAIN * place, FARTHEST_REACH)

    def step(self, s: RegistrationSettings) -> None:
        """One step; it is over where it was small, or where there is nothing to solve."""
        self.steps += 1
        # While the way is being found, as far as the prior is uncertain.
        finding = self._part is not self._scan
        reach = max(s.reach, self._far) if finding else s.reach
        weighing = FINDING if finding else TELLING
        self.fit = linearised(self._part, self._scene, self.T, reach, weighing).believable()
        if self.fit.inliers < FEWEST:
            self.T, self.change = self._prior, np.zeros(6)
            self.moved, self.over = False, True
            return
        gradient = self.fit.gradient + self._held @ self.change
        delta = -np.linalg.solve(self.fit.hessian + self._held + 1e-9 * np.eye(6), gradient)
        self.T = self.T @ se3_matrices.exp(delta)
        self.change = se3_matrices.log(self._back @ self.T)
        self.moved = True
        self._judge(delta, s)

    def _judge(self, delta: NDArray[np.floating], s: RegistrationSettings) -> None:
        turn, shift = np.linalg.norm(delta.reshape(2, 3), axis=1)
        small = turn < s.turn and shift < s.shift
        # Correspondences that flicker keep the last steps from vanishing; what is less than the
        # uncertainty means nothing.
        late = self.steps >= s.rounds // 2
        meant = float(delta @ (self.fit.hessian + self._held) @ delta)
        smallish = (turn < COARSE * s.turn and shift < COARSE * s.shift) or meant < MEANT**2
        if self._part is self._scan and (small or (smallish and late)):
            self.converged = self.over = True
        elif smallish or late:
            self._part = self._scan
