"""Distances between poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


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
