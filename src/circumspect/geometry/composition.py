"""Fast products and distances of poses for operations on every frame.

SciPy orthonormalises the rotation of every product by a singular value decomposition with many
checks: 0.1 ms to 0.3 ms each, several milliseconds a frame. Rounding reduces orthonormality by
1e-16 per product, which needs no repair within a robot's run.
"""

from __future__ import annotations

from functools import reduce
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform


def composed(*transforms: RigidTransform) -> RigidTransform:
    """The product of `T_a_b`, `T_b_c` and so on, as by `*`.

    Args:
        transforms: Single ones, at least one.
    """
    return orthonormal(reduce(np.matmul, [T.as_matrix() for T in transforms]))


def between(T_a_b: RigidTransform, T_a_c: RigidTransform) -> RigidTransform:
    """`T_b_c` of two single poses in one frame, as by `T_a_b.inv() * T_a_c`."""
    first, second = T_a_b.as_matrix(), T_a_c.as_matrix()
    turned_back = first[:3, :3].T
    matrix = np.eye(4)
    matrix[:3, :3] = turned_back @ second[:3, :3]
    matrix[:3, 3] = turned_back @ (second[:3, 3] - first[:3, 3])
    return orthonormal(matrix)


def orthonormal(matrix: NDArray[np.floating]) -> RigidTransform:
    """The pose of a (4, 4) matrix whose rotation is known to be orthonormal; it is not copied."""
    from scipy.spatial.transform import RigidTransform

    return RigidTransform(matrix, normalize=False, copy=False)


def distances(
    poses: NDArray[np.floating], pose: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Translation and rotation distances from poses to one reference pose.

    The rotation angle θ between R₁ and R₂ follows from ‖R₁ - R₂‖² = 8 sin²(θ/2).

    Args:
        poses: (…, 4, 4).
        pose: (4, 4) reference, or one for each pose.

    Returns:
        (…) [m] and (…) [rad].
    """
    between = poses[..., :3, :] - pose[..., :3, :]
    translation = np.sqrt(np.einsum("...i,...i->...", between[..., 3], between[..., 3]))
    rotation = between[..., :3]
    half_sine = np.sqrt(np.einsum("...ij,...ij->...", rotation, rotation) / 8)
    return translation, 2 * np.arcsin(np.minimum(half_sine, 1))
