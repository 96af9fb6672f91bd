"""SE(3) algebra on plain 4 x 4 matrices, for inner loops.

SciPy's `RigidTransform` validates every call, which dominates the cost of a single product.
Conventions and formulas are those of `se3`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

MIN_CLOSED_FORM_RAD = 1e-4
"""Smaller rotations [rad] use series in place of the closed form."""
MIN_LOG_COSINE = -0.9
"""Rotations with a smaller cosine, near a half turn, use SciPy's logarithm."""


def exp(xi: NDArray[np.floating]) -> NDArray[np.float64]:
    """(4, 4) exponential of a (6,) tangent vector ξ [rad, m]."""
    angle = float(np.sqrt(xi[:3] @ xi[:3]))
    if angle < MIN_CLOSED_FORM_RAD:
        a, b, c = 1 - angle**2 / 6, 0.5 - angle**2 / 24, 1 / 6 - angle**2 / 120
    else:
        a, b = np.sin(angle) / angle, (1 - np.cos(angle)) / angle**2
        c = (1 - a) / angle**2
    K = skew(xi)
    K2 = K @ K
    T = np.eye(4)
    T[:3, :3] += a * K + b * K2
    T[:3, 3] = xi[3:] + (b * K + c * K2) @ xi[3:]
    return T


def log(T: NDArray[np.floating]) -> NDArray[np.float64]:
    """(6,) [rad, m] logarithm of a (4, 4) transform, the inverse of `exp`."""
    w = 0.5 * np.array([T[2, 1] - T[1, 2], T[0, 2] - T[2, 0], T[1, 0] - T[0, 1]])
    sine, cosine = float(np.sqrt(w @ w)), 0.5 * (T[0, 0] + T[1, 1] + T[2, 2] - 1)
    if cosine < MIN_LOG_COSINE:
        return RigidTransform.from_matrix(T).as_exp_coords()
    angle = float(np.arctan2(sine, cosine))
    xi = np.empty(6)
    if angle < MIN_CLOSED_FORM_RAD:
        xi[:3] = w * (1 + angle**2 / 6)
        k = 1 / 12 + angle**2 / 720
    else:
        xi[:3] = w * (angle / sine)
        k = (1 - angle * sine / (2 * (1 - cosine))) / angle**2
    K = skew(xi)
    t = T[:3, 3]
    xi[3:] = t - 0.5 * (K @ t) + k * (K @ (K @ t))
    return xi


def exps(xis: NDArray[np.floating]) -> NDArray[np.float64]:
    """(n, 4, 4) exponentials of (n, 6) tangent vectors [rad, m]."""
    return RigidTransform.from_exp_coords(xis).as_matrix()


def logs(T: NDArray[np.floating]) -> NDArray[np.float64]:
    """(n, 6) [rad, m] logarithms of (n, 4, 4) transforms; rotations must be orthonormal."""
    return RigidTransform(T, normalize=False, copy=False).as_exp_coords()


def inverse(T: NDArray[np.floating]) -> NDArray[np.float64]:
    """(…, 4, 4) inverse transforms; rotations must be orthonormal."""
    result = np.zeros(T.shape)
    R = np.swapaxes(T[..., :3, :3], -1, -2)
    result[..., :3, :3] = R
    result[..., :3, 3] = -(R @ T[..., :3, 3, None])[..., 0]
    result[..., 3, 3] = 1
    return result


def skew(v: NDArray[np.floating]) -> NDArray[np.float64]:
    """(3, 3) matrix [v]× with [v]× w = v × w; reads the first three components of v."""
    x, y, z = v[0], v[1], v[2]
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def skews(v: NDArray[np.floating]) -> NDArray[np.float64]:
    """(…, 3, 3) matrices [v]× of (…, 3) vectors."""
    result = np.zeros((*v.shape[:-1], 3, 3))
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    result[..., 0, 1], result[..., 0, 2], result[..., 1, 2] = -z, y, -x
    result[..., 1, 0], result[..., 2, 0], result[..., 2, 1] = z, -y, x
    return result


def adjoint(T: NDArray[np.floating]) -> NDArray[np.float64]:
    """(…, 6, 6) adjoint matrices of (…, 4, 4) transforms; see `se3.adjoint`."""
    R, t = T[..., :3, :3], T[..., :3, 3]
    result = np.zeros((*T.shape[:-2], 6, 6))
    result[..., :3, :3] = result[..., 3:, 3:] = R
    result[..., 3:, :3] = (skews(t) if t.ndim > 1 else skew(t)) @ R
    return result
