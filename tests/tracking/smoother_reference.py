"""NumPy reference of the normal equations of the smoother's window, written for clarity."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3, se3_matrices
from circumspect.tracking.smoother_window import CAUCHY_SCALE, Window

Array = NDArray[np.float64]


class NormalEquations:
    """The Hessian and the gradient of half the cost."""

    def __init__(self, size: int) -> None:
        self.hessian, self.gradient = np.zeros((size, size)), np.zeros(size)

    def add(self, at: list[int], error: Array, J: Array, omega: Array) -> None:
        """Add a factor of these variables."""
        self.hessian[np.ix_(at, at)] += J.T @ omega @ J
        self.gradient[at] += J.T @ omega @ error


def linearised(window: Window, count: int | None = None) -> tuple[Array, Array]:
    """Reference of `Window.linearised`."""
    count = len(window.poses) if count is None else count
    size = 6 * min(count + 1, len(window.poses)) + 2
    equations, factors = NormalEquations(size), window.factors
    scale = [size - 2, size - 1]
    _add_prior(equations, window)
    for k in range(count):
        pose, following = (list(range(6 * i, 6 * i + 6)) for i in (k, k + 1))
        error = _log(se3_matrices.inverse(factors.measured[k]) @ window.poses[k])
        J = se3.right_jacobian_inverse(error)
        equations.add(pose, error, J, _robust(factors.measured_information[k], error))
        error, J = se3.level_errors(window.poses[k], factors.mounts[k])
        equations.add(pose, error, J, factors.level_information[k])
        if k + 1 < len(window.poses):
            error, J = _motion(window, k)
            omega = _robust(factors.motion_information[k], error)
            equations.add(pose + following + scale, error, J, omega)
    return equations.hessian, equations.gradient


def _add_prior(equations: NormalEquations, window: Window) -> None:
    prior, size = window.prior, len(equations.gradient)
    change = _log(se3_matrices.inverse(prior.T_map_camera) @ window.poses[0])
    J = np.eye(8)
    J[:6, :6] = se3.right_jacobian_inverse(change)
    error = np.concatenate([change, window.scale - prior.scale])
    equations.add([*range(6), size - 2, size - 1], error, J, prior.information)


def _motion(window: Window, k: int) -> tuple[Array, Array]:
    """(6,) error of a motion and (6, 14) its derivative by both poses and the scale."""
    by_scale = window.factors.by_scale[k]
    change = se3_matrices.exps(by_scale @ (window.scale - 1))
    expected = window.factors.motions[k] @ change
    between = se3_matrices.inverse(window.poses[k]) @ window.poses[k + 1]
    error = _log(se3_matrices.inverse(expected) @ between)
    J2 = se3.right_jacobian_inverse(error)
    J1 = -J2 @ se3_matrices.adjoint(se3_matrices.inverse(between))
    J3 = -se3.right_jacobian_inverse(-error) @ by_scale
    return error, np.hstack([J1, J2, J3])


def _log(T: Array) -> Array:
    return se3_matrices.logs(T[None])[0]


def _robust(omega: Array, error: Array) -> Array:
    """Information weighted by Cauchy's kernel."""
    return omega / (1 + error @ omega @ error / CAUCHY_SCALE**2)
