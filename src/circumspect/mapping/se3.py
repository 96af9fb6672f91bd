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

from circumspect.mapping import rigid_matrix


def exp(change: ArrayLike) -> RigidTransform:
    """The motion of a change: (6,), or (n, 6) for a batch, [rad, m]."""
    return RigidTransform.from_exp_coords(np.asarray(change, np.float64))


def log(T: RigidTransform) -> NDArray[np.float64]:
    """(6,) or (n, 6) [rad, m]: the change of a motion; the inverse of `exp`."""
    return T.as_exp_coords()


def adjoint(T: RigidTransform) -> NDArray[np.float64]:
    """(…, 6, 6) Ad with T exp(ξ) = exp(Ad ξ) T: the same change, told in the other frame."""
    return rigid_matrix.adjoint(T.as_matrix())


def right_jacobian_inverse(change: NDArray[np.floating]) -> NDArray[np.float64]:
    """(…, 6, 6) J with log(exp(ξ) exp(δ)) = ξ + J δ for small δ.

    The series with Bernoulli's numbers, 1 + ad/2 + ad²/12 - ad⁴/720; for turns below one radian
    right to 1e-4.

    Args:
        change: (…, 6) ξ [rad, m].
    """
    ad = np.zeros((*change.shape[:-1], 6, 6))
    ad[..., :3, :3] = ad[..., 3:, 3:] = rigid_matrix.skews(change[..., :3])
    ad[..., 3:, :3] = rigid_matrix.skews(change[..., 3:])
    square = ad @ ad
    return np.eye(6) + ad / 2 + square / 12 - square @ square / 720


def moved_covariance(
    T_to_from: RigidTransform, covariance: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(6, 6) a covariance of changes in frame `from`, told in frame `to`."""
    Ad = adjoint(T_to_from)
    return Ad @ covariance @ Ad.T


def moved_information(
    T_to_from: RigidTransform, information: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(6, 6) an inverse covariance of changes in frame `from`, told in frame `to`."""
    Ad = adjoint(T_to_from.inv())
    return Ad.T @ information @ Ad


def largest_deviations(covariance: NDArray[np.floating]) -> tuple[float, float]:
    """Largest standard deviations of the turn [rad] and of the place [m], of (6, 6)."""
    blocks = covariance[:3, :3], covariance[3:, 3:]
    turn, place = (float(np.sqrt(np.linalg.eigvalsh(block)[-1])) for block in blocks)
    return turn, place


def level_error(
    T_map_camera: RigidTransform, T_base_camera: RigidTransform
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How a robot departs from standing level at z = 0.

    Args:
        T_map_camera: One camera pose, or n.
        T_base_camera: Its mount, or n.

    Returns:
        (…, 3) roll [rad], pitch [rad] and height [m] of the base, and (…, 3, 6) their derivative
        by changes of the camera's pose.
    """
    return level_errors(T_map_camera.as_matrix(), T_base_camera.as_matrix())


def level_errors(
    T_map_camera: NDArray[np.float64], T_base_camera: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The same of (…, 4, 4) matrices."""
    matrix = T_map_camera @ rigid_matrix.inverse(T_base_camera)
    # The third row of the rotation is the map's z in the base's frame: (0, 0, 1) when level.
    up = matrix[..., 2, :3]
    by_base = np.zeros((*up.shape[:-1], 3, 6))
    by_base[..., 0, 0] = by_base[..., 1, 1] = up[..., 2]
    by_base[..., 2, 3:] = up
    error = np.stack([up[..., 1], -up[..., 0], matrix[..., 2, 3]], axis=-1)
    return error, by_base @ rigid_matrix.adjoint(T_base_camera)
