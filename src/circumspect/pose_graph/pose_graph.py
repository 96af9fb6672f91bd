"""The pose graph: optimisation and marginal covariances."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3_matrices
from circumspect.geometry.composition import orthonormal
from circumspect.pose_graph.factors import BetweenFactor, LevelFactor
from circumspect.pose_graph.normal_equations import MIN_INFORMATION, GraphProblem, GraphState

if TYPE_CHECKING:
    from scipy.sparse import csc_array

MAX_ITERATIONS = 30
"""Maximum number of steps, rejected ones included."""
CONVERGENCE_TOLERANCE = 1e-7
"""The iteration has converged if no pose changes by more than this [rad], [m]."""
MIN_DAMPING, MIN_RAISED_DAMPING, MAX_DAMPING = 1e-9, 1e-6, 1e6
"""Initial damping, minimum damping after a rejected step, and damping that ends the iteration."""


@dataclass(frozen=True, eq=False)
class PoseGraph:
    """Poses `T_map_camera` and factors between them. The first pose is fixed.

    Attributes:
        poses: At least one pose.
        between_factors: Relative measurements.
        level_factors: Measurements of level robots.
    """

    poses: tuple[RigidTransform, ...]
    between_factors: tuple[BetweenFactor, ...] = ()
    level_factors: tuple[LevelFactor, ...] = ()

    @property
    def cost(self) -> float:
        """Σ ρ(eᵀ Ω e) over the between factors and Σ eᵀ Ω e over the level factors."""
        return self._state.cost

    def optimised(self) -> PoseGraph:
        """The graph at the nearest minimum of the cost, by Gauss-Newton.

        The error of a between factor is e = log(Z⁻¹ T₁⁻¹ T₂) with Z the measurement (Grisetti et
        al., "A tutorial on graph-based SLAM", 2010). Steps that raise the cost are rejected and
        damped after Levenberg and Marquardt. Poses without factors stay.

        Returns:
            A new graph; this one if it has fewer than two poses or no between factors.
        """
        if len(self.poses) < 2 or not self.between_factors:
            return self
        state, damping = self._state, MIN_DAMPING
        cost = state.cost
        for _ in range(MAX_ITERATIONS):
            step = state.step(damping)
            candidate = state.moved(step)
            candidate_cost = candidate.cost
            # Also rejects a cost that is not finite.
            if not candidate_cost <= cost * (1 + 1e-12) + 1e-15:
                damping = max(MIN_RAISED_DAMPING, 10 * damping)
                if damping > MAX_DAMPING:
                    break
                continue
            state, cost, damping = candidate, candidate_cost, max(damping / 10, MIN_DAMPING)
            if np.abs(step).max() < CONVERGENCE_TOLERANCE:
                break
        return replace(self, poses=tuple(map(orthonormal, state.poses)))

    @property
    def hessian(self) -> csc_array:
        """(6 n, 6 n) Hessian of half the cost, with robust weights."""
        from scipy.sparse import csc_array, eye_array

        H, _ = self._state.linearised()
        return csc_array(H + MIN_INFORMATION * eye_array(6 * len(self.poses)))

    @property
    def _state(self) -> GraphState:
        poses = np.stack([pose.as_matrix() for pose in self.poses])
        return GraphProblem.from_factors(self.between_factors, self.level_factors).at(poses)


def marginal_covariances(
    graph: PoseGraph, first_covariance: NDArray[np.floating]
) -> NDArray[np.floating]:
    """Marginal covariances of all poses at the current estimate.

    They are the diagonal blocks of the inverse Hessian (Kaess and Dellaert, "Covariance recovery
    from a square root information matrix for data association", 2009) with robust weights. The
    graph fixes its first pose; the covariance of the first pose is added to all others.

    Args:
        graph: A graph at its optimum. Poses that no path of factors connects to the first one have
            no finite covariance.
        first_covariance: (6, 6) of the first pose [rad, m].

    Returns:
        (n, 6, 6) [rad, m], in the frame of each pose.
    """
    n = len(graph.poses)
    covariances = np.zeros((n, 6, 6))
    if n > 1:
        # The inverse is dense; dense algebra computes it fastest.
        inverse = np.linalg.inv(graph.hessian[6:, 6:].toarray()).reshape(n - 1, 6, n - 1, 6)
        k = np.arange(n - 1)
        covariances[1:] = inverse[k, :, k]
    poses = np.stack([pose.as_matrix() for pose in graph.poses])
    Ad = se3_matrices.adjoint(se3_matrices.inverse(poses) @ poses[0])
    covariances += Ad @ first_covariance @ np.swapaxes(Ad, -1, -2)
    return (covariances + np.swapaxes(covariances, -1, -2)) / 2
