"""The least squares of a pose graph, all measurements at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3, se3_matrices

if TYPE_CHECKING:
    from circumspect.mapping.pose_graph import Edge, Level

KERNEL = 6.0
"""c of Cauchy's kernel, in units of the normalised error; six degrees of freedom make √6."""

Stack = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GraphProblem:
    """What was measured, as arrays over m edges and k levels.

    Attributes:
        first, second: (m,) which poses.
        back: (m, 4, 4) Z⁻¹, the measurements the other way round.
        omega: (m, 6, 6) their information.
        robust: (m,) bool: weighted by Cauchy's kernel.
        level: (k,) which poses stand level.
        mounts: (k, 4, 4) `T_base_camera` of these.
        level_omega: (k, 3, 3) information of roll, pitch and height.
    """

    first: NDArray[np.intp]
    second: NDArray[np.intp]
    back: Stack
    omega: Stack
    robust: NDArray[np.bool_]
    level: NDArray[np.intp]
    mounts: Stack
    level_omega: Stack

    @staticmethod
    def of(edges: Sequence[Edge], levels: Sequence[Level]) -> GraphProblem:
        """Stack measurements."""
        measured = [edge.T_first_second.as_matrix() for edge in edges]
        return GraphProblem(
            np.array([edge.first for edge in edges], np.intp),
            np.array([edge.second for edge in edges], np.intp),
            se3_matrices.inverse(_stacked(measured, (4, 4))),
            _stacked([edge.information for edge in edges], (6, 6)),
            np.array([edge.robust for edge in edges], bool),
            np.array([level.number for level in levels], np.intp),
            _stacked([level.T_base_camera.as_matrix() for level in levels], (4, 4)),
            _stacked([level.information for level in levels], (3, 3)),
        )

    def at(self, poses: Stack) -> GraphState:
        """The problem at (n, 4, 4) poses."""
        between = se3_matrices.inverse(poses[self.first]) @ poses[self.second]
        errors = se3_matrices.logs(self.back @ between)
        level_errors, J = se3.level_errors(poses[self.level], self.mounts)
        return GraphState(self, poses, between, errors, level_errors, J)


@dataclass(frozen=True, eq=False)
class GraphState:
    """Errors and derivatives at some poses.

    Attributes:
        problem: What was measured.
        poses: (n, 4, 4) `T_map_camera`.
        between: (m, 4, 4) T₁⁻¹T₂ of the edges.
        errors: (m, 6) e = log(Z⁻¹ T₁⁻¹ T₂).
        level_errors: (k, 3) roll, pitch and height.
        level_J: (k, 3, 6) their derivatives.
    """

    problem: GraphProblem
    poses: Stack
    between: Stack
    errors: Stack
    level_errors: Stack
    level_J: Stack

    @property
    def squares(self) -> Stack:
        """(m,) eᵀ Ω e of the edges."""
        return np.einsum("mi,mi->m", self.errors, _applied(self.problem.omega, self.errors))

    @property
    def cost(self) -> float:
        """Σ ρ(eᵀ Ω e) over the edges and Σ eᵀ Ω e over the levels."""
        squares, levels = self.squares, self.level_errors
        robust = KERNEL**2 * np.log1p(squares / KERNEL**2)
        total = float(np.where(self.problem.robust, robust, squares).sum())
        return total + float((levels * _applied(self.problem.level_omega, levels)).sum())

    def step(self, damping: float) -> Stack:
        """(n, 6) the Gauss-Newton step; zero for the first pose."""
        from scipy.sparse import coo_array, csc_array, diags_array
        from scipy.sparse.linalg import spsolve

        blocks, rows, columns, gradient = self._normal_equations()
        size, cell = gradient.size, np.arange(6)
        i = np.broadcast_to(6 * rows[:, None, None] + cell[:, None], blocks.shape)
        j = np.broadcast_to(6 * columns[:, None, None] + cell[None, :], blocks.shape)
        H = coo_array((blocks.ravel(), (i.ravel(), j.ravel())), shape=(size, size))
        # Poses that nothing holds stay where they are.
        H = csc_array(H + diags_array(damping * H.diagonal() + 1e-9))
        step = np.zeros(size)
        step[6:] = -spsolve(H[6:, 6:], gradient.ravel()[6:])
        return step.reshape(-1, 6)

    def moved(self, step: Stack) -> GraphState:
        """The same problem after a step (n, 6)."""
        return self.problem.at(self.poses @ se3_matrices.exps(step))

    def _normal_equations(
        self,
    ) -> tuple[Stack, NDArray[np.intp], NDArray[np.intp], Stack]:
        """Blocks (6, 6) of the Hessian with their rows and columns, and the gradient (n, 6)."""
        problem = self.problem
        first, second, level = problem.first, problem.second, problem.level
        weights = np.where(problem.robust, 1 / (1 + self.squares / KERNEL**2), 1.0)
        J2 = se3.right_jacobian_inverse(self.errors)
        J1 = -J2 @ se3_matrices.adjoint(se3_matrices.inverse(self.between))
        omega = problem.omega * weights[:, None, None]
        J1_omega, J2_omega = _turned(J1) @ omega, _turned(J2) @ omega
        J0_omega = _turned(self.level_J) @ problem.level_omega
        gradient = np.zeros((len(self.poses), 6))
        np.add.at(gradient, first, _applied(J1_omega, self.errors))
        np.add.at(gradient, second, _applied(J2_omega, self.errors))
        np.add.at(gradient, level, _applied(J0_omega, self.level_errors))
        blocks = J1_omega @ J1, J1_omega @ J2, J2_omega @ J1, J2_omega @ J2, J0_omega @ self.level_J
        rows, columns = (first, first, second, second, level), (first, second, first, second, level)
        return np.concatenate(blocks), np.concatenate(rows), np.concatenate(columns), gradient


def _stacked(matrices: Sequence[NDArray[np.floating]], shape: tuple[int, int]) -> Stack:
    return np.asarray(matrices, np.float64).reshape(-1, *shape)


def _turned(matrices: Stack) -> Stack:
    return np.swapaxes(matrices, -1, -2)


def _applied(matrices: Stack, vectors: Stack) -> Stack:
    """(m, a) products of (m, a, b) and (m, b)."""
    return (matrices @ vectors[..., None])[..., 0]
