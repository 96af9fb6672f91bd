"""Stacked factors of a pose graph, and their normal equations at given poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3, se3_matrices
from circumspect.pose_graph.factors import BetweenFactor, LevelFactor

if TYPE_CHECKING:
    from scipy.sparse import csc_array

CAUCHY_SCALE = 6.0
"""Scale c of Cauchy's kernel, in units of the normalised error. Six degrees of freedom give √6."""
MIN_INFORMATION = 1e-9
"""Added to the diagonal of Hessians, so that poses without factors stay."""

Stack = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class GraphProblem:
    """Measurements of m between factors and k level factors, stacked.

    Attributes:
        first: (m,) index of the first pose.
        second: (m,) index of the second pose.
        T_second_first: (m, 4, 4) inverse measurements Z⁻¹.
        information: (m, 6, 6) Ω.
        robust: (m,) bool, weighted by Cauchy's kernel.
        level_pose: (k,) index of the level pose.
        T_base_camera: (k, 4, 4) mounts of the level poses.
        level_information: (k, 3, 3) information of roll, pitch and height.
    """

    first: NDArray[np.intp]
    second: NDArray[np.intp]
    T_second_first: Stack
    information: Stack
    robust: NDArray[np.bool_]
    level_pose: NDArray[np.intp]
    T_base_camera: Stack
    level_information: Stack

    @staticmethod
    def from_factors(
        between_factors: Sequence[BetweenFactor], level_factors: Sequence[LevelFactor]
    ) -> GraphProblem:
        """Stack factors."""
        measured = [factor.T_first_second.as_matrix() for factor in between_factors]
        mounts = [factor.T_base_camera.as_matrix() for factor in level_factors]
        return GraphProblem(
            np.array([factor.first for factor in between_factors], np.intp),
            np.array([factor.second for factor in between_factors], np.intp),
            se3_matrices.inverse(_stacked(measured, (4, 4))),
            _stacked([factor.information for factor in between_factors], (6, 6)),
            np.array([factor.robust for factor in between_factors], bool),
            np.array([factor.pose for factor in level_factors], np.intp),
            _stacked(mounts, (4, 4)),
            _stacked([factor.information for factor in level_factors], (3, 3)),
        )

    def at(self, poses: Stack) -> GraphState:
        """Errors and derivatives at (n, 4, 4) poses."""
        T_first_second = se3_matrices.inverse(poses[self.first]) @ poses[self.second]
        errors = se3_matrices.logs(self.T_second_first @ T_first_second)
        level_errors, J = se3.level_errors(poses[self.level_pose], self.T_base_camera)
        return GraphState(self, poses, T_first_second, errors, level_errors, J)


@dataclass(frozen=True, eq=False)
class GraphState:
    """Errors and derivatives at given poses.

    Attributes:
        problem: The stacked factors.
        poses: (n, 4, 4) `T_map_camera`.
        T_first_second: (m, 4, 4) T₁⁻¹T₂ at the poses.
        errors: (m, 6) e = log(Z⁻¹ T₁⁻¹ T₂).
        level_errors: (k, 3) roll, pitch and height.
        level_jacobians: (k, 3, 6) their derivatives.
    """

    problem: GraphProblem
    poses: Stack
    T_first_second: Stack
    errors: Stack
    level_errors: Stack
    level_jacobians: Stack

    @property
    def squared_errors(self) -> Stack:
        """(m,) eᵀ Ω e of the between factors."""
        return np.einsum("mi,mi->m", self.errors, _products(self.problem.information, self.errors))

    @property
    def cost(self) -> float:
        """Σ ρ(eᵀ Ω e) over the between factors and Σ eᵀ Ω e over the level factors."""
        squares, levels = self.squared_errors, self.level_errors
        robust = CAUCHY_SCALE**2 * np.log1p(squares / CAUCHY_SCALE**2)
        total = float(np.where(self.problem.robust, robust, squares).sum())
        return total + float((levels * _products(self.problem.level_information, levels)).sum())

    def step(self, damping: float) -> Stack:
        """The damped Gauss-Newton step.

        Args:
            damping: Multiple of the Hessian's diagonal that is added to it.

        Returns:
            (n, 6) changes of the poses in their own frames; zero for the first pose.
        """
        from scipy.sparse import csc_array, diags_array
        from scipy.sparse.linalg import spsolve

        H, gradient = self.linearised()
        # Poses without factors stay.
        H = csc_array(H + diags_array(damping * H.diagonal() + MIN_INFORMATION))
        step = np.zeros(gradient.size)
        step[6:] = -spsolve(H[6:, 6:], gradient.ravel()[6:])
        return step.reshape(-1, 6)

    def linearised(self) -> tuple[csc_array, Stack]:
        """The normal equations with robust weights.

        Returns:
            (6 n, 6 n) sparse Hessian, and (n, 6) gradient of half the cost.
        """
        from scipy.sparse import coo_array

        blocks, rows, columns, gradient = self._normal_equations()
        size, cell = gradient.size, np.arange(6)
        i = np.broadcast_to(6 * rows[:, None, None] + cell[:, None], blocks.shape)
        j = np.broadcast_to(6 * columns[:, None, None] + cell[None, :], blocks.shape)
        H = coo_array((blocks.ravel(), (i.ravel(), j.ravel())), shape=(size, size))
        return H.tocsc(), gradient

    def moved(self, step: Stack) -> GraphState:
        """The state after a step (n, 6)."""
        return self.problem.at(self.poses @ se3_matrices.exps(step))

    def _normal_equations(
        self,
    ) -> tuple[Stack, NDArray[np.intp], NDArray[np.intp], Stack]:
        """Blocks (6, 6) of the Hessian with their rows and columns, and the gradient (n, 6)."""
        problem = self.problem
        first, second, level = problem.first, problem.second, problem.level_pose
        weights = np.where(problem.robust, 1 / (1 + self.squared_errors / CAUCHY_SCALE**2), 1.0)
        J2 = se3.right_jacobian_inverse(self.errors)
        J1 = -J2 @ se3_matrices.adjoint(se3_matrices.inverse(self.T_first_second))
        J0 = self.level_jacobians
        omega = problem.information * weights[:, None, None]
        J1_omega, J2_omega = _transposed(J1) @ omega, _transposed(J2) @ omega
        J0_omega = _transposed(J0) @ problem.level_information
        gradient = np.zeros((len(self.poses), 6))
        np.add.at(gradient, first, _products(J1_omega, self.errors))
        np.add.at(gradient, second, _products(J2_omega, self.errors))
        np.add.at(gradient, level, _products(J0_omega, self.level_errors))
        blocks = J1_omega @ J1, J1_omega @ J2, J2_omega @ J1, J2_omega @ J2, J0_omega @ J0
        rows, columns = (first, first, second, second, level), (first, second, first, second, level)
        return np.concatenate(blocks), np.concatenate(rows), np.concatenate(columns), gradient


def _stacked(matrices: Sequence[NDArray[np.floating]], shape: tuple[int, int]) -> Stack:
    return np.asarray(matrices, np.float64).reshape(-1, *shape)


def _transposed(matrices: Stack) -> Stack:
    return np.swapaxes(matrices, -1, -2)


def _products(matrices: Stack, vectors: Stack) -> Stack:
    """(m, a) products of (m, a, b) and (m, b)."""
    return (matrices @ vectors[..., None])[..., 0]
