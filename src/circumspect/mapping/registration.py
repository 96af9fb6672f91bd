"""Scan-to-model registration: the pose from which a scan fits the scene best."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.mapping import rigid_matrix
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
AVERTED = 0.1
"""Surfaces whose normals make a larger cosine than this with the line of sight show their back,
which no camera sees: the far side of a thin board is not taken for the near one."""
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
class LinearFit:
    """The point-to-plane problem, linear about one pose.

    Attributes:
        hessian, gradient: (6, 6) and (6,) of half the sum of weighted squares.
        inliers, overlap, distance, residual, misfit: See `Registration`.
    """

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
        self._prior, self._back = prior, rigid_matrix.inverse(prior)
        self._held = prior_information
        self._scan, self._scene, self._part = scan, scene, scan.thinned(THINNED)

    def step(self, s: RegistrationSettings) -> None:
        """One step; it is over where it was small, or where there is nothing to solve."""
        self.steps += 1
        self.fit = linearised(self._part, self._scene, self.T, s.reach)
        if self.fit.inliers < FEWEST:
            self.T, self.change = self._prior, np.zeros(6)
            self.moved, self.over = False, True
            return
        gradient = self.fit.gradient + self._held @ self.change
        delta = -np.linalg.solve(self.fit.hessian + self._held + 1e-9 * np.eye(6), gradient)
        self.T = self.T @ rigid_matrix.exp(delta)
        self.change = rigid_matrix.log(self._back @ self.T)
        self.moved = True
        self._judge(delta, s)

    def _judge(self, delta: NDArray[np.floating], s: RegistrationSettings) -> None:
        turn, shift = np.linalg.norm(delta.reshape(2, 3), axis=1)
        small = turn < s.turn and shift < s.shift
        smallish = turn < COARSE * s.turn and shift < COARSE * s.shift
        # Correspondences that flicker keep the last steps from vanishing.
        late = self.steps >= s.rounds // 2
        if self._part is self._scan and (small or (smallish and late)):
            self.converged = self.over = True
        elif smallish:
            self._part = self._scan


def linearised(scan: Scan, scene: SceneMap, T: NDArray[np.float64], reach: float) -> LinearFit:
    """The point-to-plane problem about one pose, in C++; its twin is in `numpy_twin`.

    Args:
        scan: The frame's points.
        scene: What they are compared with.
        T: (4, 4) `T_map_camera`.
        reach: Points further than this [m] from the map have no correspondence.
    """
    if len(scan) == 0 or len(scene) == 0:
        return LinearFit()
    return LinearFit(
        *scene.planes.linearised(
            scan.points_xyz,
            scan.sigmas,
            T,
            reach=reach,
            tukey=TUKEY,
            correlation=CORRELATION,
            least_spread=LEAST_SPREAD,
            floor=FLOOR,
            far=FAR,
            averted=AVERTED,
            standing=STANDING,
            fewest=FEWEST,
        )
    )
