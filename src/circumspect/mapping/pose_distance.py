"""How far poses are from each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def distances(
    poses: NDArray[np.float64], pose: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Shifts and turns between poses and another one.

    With θ the turn from R₁ to R₂, ‖R₁ - R₂‖² = 8 sin²(θ/2).

    Args:
        poses: (…, 4, 4).
        pose: (4, 4).

    Returns:
        (…) [m] and (…) [rad].
    """
    between = poses[..., :3, :] - pose[:3, :]
    shift = np.sqrt(np.einsum("...i,...i->...", between[..., 3], between[..., 3]))
    turned = between[..., :3]
    chord = np.sqrt(np.einsum("...ij,...ij->...", turned, turned) / 8)
    return shift, 2 * np.arcsin(np.minimum(chord, 1))
