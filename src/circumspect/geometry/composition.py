"""Products of single poses, for what is done with every frame.

SciPy makes the rotation of every product orthonormal anew, by a singular value decomposition
behind many checks: 0.1 ms to 0.3 ms each, several milliseconds a frame. Rounding spoils
orthonormality by 1e-16 a product, so that it needs no repair for as long as a robot drives.
"""

from __future__ import annotations

from functools import reduce
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform


def composed(*transforms: RigidTransform) -> RigidTransform:
    """`T_a_b`, `T_b_c` and so on, as by `*`: the last one's frame told in the first one's.

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
