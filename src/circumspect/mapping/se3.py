"""Rigid motions and their small changes.

A change ξ = (φ, ρ) is a turn φ [rad] and a shift ρ [m], in this order, applied on the right:
T ⊕ ξ = T exp(ξ). So ξ is told in the frame that T takes from: the camera's, the robot's.
Formulas after Solà, Deray and Atchuthan, "A micro Lie theory for state estimation in robotics"
(2018), with their order of shift and turn exchanged to SciPy's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform


def exp(change: ArrayLike) -> RigidTransform:
    """The motion of a change: (6,), or (n, 6) for a batch, [rad, m]."""
    return RigidTransform.from_exp_coords(np.asarray(change, np.float64))


def log(T: RigidTransform) -> NDArray[np.float64]:
    """(6,) or (n, 6) [rad, m]: the change of a motion; the inverse of `exp`."""
    return T.as_exp_coords()


def skew(v: NDArray[np.floating]) -> NDArray[np.float64]:
    """(3, 3) the matrix [v]× with [v]× w = v × w."""
    x, y, z = (float(value) for value in v)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def adjoint(T: RigidTransform) -> NDArray[np.float64]:
    """(6, 6) Ad with T exp(ξ) = exp(Ad ξ) T: the same change, told in the other frame."""
    matrix = T.as_matrix()
    R, t = matrix[:3, :3], matrix[:3, 3]
    result = np.zeros((6, 6))
    result[:3, :3] = result[3:, 3:] = R
    result[3:, :3] = skew(t) @ R
    return result


def small_adjoint(change: NDArray[np.floating]) -> NDArray[np.float64]:
    """(6, 6) ad with ad ξ' = [ξ, ξ'], the derivative of `adjoint`."""
    result = np.zeros((6, 6))
    result[:3, :3] = result[3:, 3:] = skew(change[:3])
    result[3:, :3] = skew(change[3:])
    return result


def right_jacobian_inverse(change: NDArray[np.floating]) -> NDArray[np.float64]:
    """(6, 6) J with log(exp(ξ) exp(δ)) = ξ + J δ for small δ.

    The series with Bernoulli's numbers up to the fourth order: for turns below one radian exact
    to 1e-4, and 0 changes nothing.
    """
    ad = small_adjoint(change)
    square = ad @ ad
    return np.eye(6) + ad / 2 + square / 12 - square @ square / 720


def moved_covariance(
    T_to_from: RigidTransform, covariance: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(6, 6) a covariance of changes in frame `from`, told in frame `to`."""
    Ad = adjoint(T_to_from)
    return Ad @ covariance @ Ad.T
