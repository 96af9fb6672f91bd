"""Start poses of registrations, so that one of them converges to the right minimum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3_matrices
from circumspect.motion import PoseWithCovariance

SPACING = float(np.radians(3.0))
"""Registration converges from rotation errors smaller than this [rad]."""
MAX_STARTS_PER_SIDE = 12
"""Maximum number of starts on each side of the prediction, summed over all axes. Starts are within
one standard deviation."""


def start_poses(prior: PoseWithCovariance) -> list[NDArray[np.floating]]:
    """Start poses that cover the rotations of a prior.

    Args:
        prior: The predicted pose.

    Returns:
        (4, 4) poses: the predicted one, then others rotated about the principal axes of its
        rotational covariance. Only one if the rotation is known to within `SPACING`.
    """
    variances, axes = np.linalg.eigh(prior.covariance[:3, :3])
    starts = [prior.T_map_camera]
    left = MAX_STARTS_PER_SIDE
    for number, (variance, axis) in enumerate(zip(variances, axes.T, strict=True)):
        # The variances ascend: starts that narrow axes do not need are left for wide ones.
        steps = min(int(np.sqrt(max(variance, 0.0)) / SPACING), left // (3 - number))
        left -= steps
        for step in (side * n for n in range(1, steps + 1) for side in (1, -1)):
            turn = se3_matrices.exp(np.concatenate([step * SPACING * axis, np.zeros(3)]))
            starts.append(prior.T_map_camera @ turn)
    return starts
