"""SE(3) algebra on SciPy's `RigidTransform`; `se3_matrices` has the same on plain matrices.

A tangent vector ξ = (φ, ρ) holds a rotation vector φ [rad] and a translation part ρ [m], in this
order. It perturbs a pose on the right, T ⊕ ξ = T exp(ξ), and is therefore expressed in the source
frame of T (the camera or the robot base). The formulas follow Solà, Deray and Atchuthan, "A micro
Lie theory for state estimation in robotics" (2018), which puts ρ first; SciPy puts φ first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3_matrices


def exp(xi: ArrayLike) -> RigidTransform:
    """Exponential map.

    Args:
        xi: (6,) ξ, or (n, 6) for a batch [rad, m].
    """
    return RigidTransform.from_exp_coords(np.asarray(xi, np.float64))


def log(T: RigidTransform) -> NDArray[np.float64]:
    """Logarithm, the inverse of `exp`: (6,), or (n, 6) for a batch [rad, m]."""
    return T.as_exp_coords()


def adjoint(T: RigidTransform) -> NDArray[np.float64]:
    """(…, 6, 6) adjoint matrix: T exp(ξ) = exp(Ad ξ) T."""
    return se3_matrices.adjoint(T.as_matrix())


def right_jacobian_inverse(xi: NDArray[np.floating]) -> NDArray[np.float64]:
    """(…, 6, 6) inverse right Jacobian J: log(exp(ξ) exp(δ)) = ξ + J δ for small δ.

    The series in Bernoulli numbers, 1 + ad/2 + ad²/12 - ad⁴/720, is truncated after this term. Its
    error is at most 1e-4 for rotations below one radian.

    Args:
        xi: (…, 6) ξ [rad, m].
    """
    ad = np.zeros((*xi.shape[:-1], 6, 6))
    ad[..., :3, :3] = ad[..., 3:, 3:] = se3_matrices.skews(xi[..., :3])
    ad[..., 3:, :3] = se3_matrices.skews(xi[..., 3:])
    square = ad @ ad
    return np.eye(6) + ad / 2 + square / 12 - square @ square / 720


def moved_covariance(
    T_to_from: RigidTransform, covariance: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(6, 6) covariance of tangent vectors in frame `from`, expressed in frame `to`."""
    Ad = adjoint(T_to_from)
    return Ad @ covariance @ Ad.T


def moved_information(
    T_to_from: RigidTransform, information: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(6, 6) information of tangent vectors in frame `from`, expressed in frame `to`."""
    Ad = adjoint(T_to_from.inv())
    return Ad.T @ information @ Ad


def largest_deviations(covariance: NDArray[np.floating]) -> tuple[float, float]:
    """Largest standard deviations of rotation [rad] and translation [m] in any direction.

    Args:
        covariance: (6, 6).
    """
    blocks = covariance[:3, :3], covariance[3:, 3:]
    rotation, translation = (float(np.sqrt(np.linalg.eigvalsh(block)[-1])) for block in blocks)
    return rotation, translation


def level_error(
    T_map_camera: RigidTransform, T_base_camera: RigidTransform
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Deviation of the robot base from the level pose at z = 0.

    Args:
        T_map_camera: One camera pose, or n.
        T_base_camera: The camera's mount, or n.

    Returns:
        (…, 3) roll [rad], pitch [rad] and height [m] of the base, and (…, 3, 6) their derivative
        with respect to a right perturbation of the camera pose.
    """
    return level_errors(T_map_camera.as_matrix(), T_base_camera.as_matrix())


def level_errors(
    T_map_camera: NDArray[np.floating], T_base_camera: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """`level_error` for (…, 4, 4) matrices."""
    matrix = T_map_camera @ se3_matrices.inverse(T_base_camera)
    # The third row of the rotation is the map's z axis in the base frame: (0, 0, 1) when level.
    up = matrix[..., 2, :3]
    by_base = np.zeros((*up.shape[:-1], 3, 6))
    by_base[..., 0, 0] = by_base[..., 1, 1] = up[..., 2]
    by_base[..., 2, 3:] = up
    error = np.stack([up[..., 1], -up[..., 0], matrix[..., 2, 3]], axis=-1)
    return error, by_base @ se3_matrices.adjoint(T_base_camera)
