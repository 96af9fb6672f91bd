"""Rigid motions as plain 4 x 4 matrices, for inner loops: SciPy's objects check too much there.

Changes (φ, ρ) and their order are those of `se3`; formulas after Solà, Deray and Atchuthan.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

SMALL = 1e-4
"""Below this turn [rad] series stand for sines and cosines."""
NEARLY_HALF_ROUND = -0.9
"""Cosine of the turns from which on the axis must be found with more care."""


def exp(change: NDArray[np.floating]) -> NDArray[np.float64]:
    """(4, 4) the motion of a (6,) change [rad, m]."""
    turn = float(np.sqrt(change[:3] @ change[:3]))
    if turn < SMALL:
        a, b, c = 1 - turn**2 / 6, 0.5 - turn**2 / 24, 1 / 6 - turn**2 / 120
    else:
        a, b = np.sin(turn) / turn, (1 - np.cos(turn)) / turn**2
        c = (1 - a) / turn**2
    K = skew(change)
    K2 = K @ K
    T = np.eye(4)
    T[:3, :3] += a * K + b * K2
    T[:3, 3] = change[3:] + (b * K + c * K2) @ change[3:]
    return T


def log(T: NDArray[np.float64]) -> NDArray[np.float64]:
    """(6,) [rad, m] the change of a (4, 4) motion; the inverse of `exp`."""
    w = 0.5 * np.array([T[2, 1] - T[1, 2], T[0, 2] - T[2, 0], T[1, 0] - T[0, 1]])
    sine, cosine = float(np.sqrt(w @ w)), 0.5 * (T[0, 0] + T[1, 1] + T[2, 2] - 1)
    if cosine < NEARLY_HALF_ROUND:
        return RigidTransform.from_matrix(T).as_exp_coords()
    turn = float(np.arctan2(sine, cosine))
    change = np.empty(6)
    if turn < SMALL:
        change[:3] = w * (1 + turn**2 / 6)
        k = 1 / 12 + turn**2 / 720
    else:
        change[:3] = w * (turn / sine)
        k = (1 - turn * sine / (2 * (1 - cosine))) / turn**2
    K = skew(change)
    t = T[:3, 3]
    change[3:] = t - 0.5 * (K @ t) + k * (K @ (K @ t))
    return change


def exps(changes: NDArray[np.floating]) -> NDArray[np.float64]:
    """(n, 4, 4) the motions of (n, 6) changes."""
    return RigidTransform.from_exp_coords(changes).as_matrix()


def logs(T: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 6) the changes of (n, 4, 4) motions whose rotations are known to be orthonormal."""
    return RigidTransform(T, normalize=False, copy=False).as_exp_coords()


def inverse(T: NDArray[np.float64]) -> NDArray[np.float64]:
    """(…, 4, 4) the motions back."""
    back = np.zeros_like(T)
    R = np.swapaxes(T[..., :3, :3], -1, -2)
    back[..., :3, :3] = R
    back[..., :3, 3] = -(R @ T[..., :3, 3, None])[..., 0]
    back[..., 3, 3] = 1
    return back


def skew(v: NDArray[np.floating]) -> NDArray[np.float64]:
    """(3, 3) the matrix [v]× with [v]× w = v × w, of the first three numbers of a vector."""
    x, y, z = v[0], v[1], v[2]
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def skews(v: NDArray[np.floating]) -> NDArray[np.float64]:
    """(…, 3, 3) the matrices [v]× of (…, 3) vectors."""
    x, y, z = np.moveaxis(np.asarray(v, np.float64), -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def adjoint(T: NDArray[np.float64]) -> NDArray[np.float64]:
    """(…, 6, 6) of (…, 4, 4) motions, see `se3.adjoint`."""
    R, t = T[..., :3, :3], T[..., :3, 3]
    result = np.zeros((*T.shape[:-2], 6, 6))
    result[..., :3, :3] = result[..., 3:, 3:] = R
    result[..., 3:, :3] = (skews(t) if t.ndim > 1 else skew(t)) @ R
    return result
