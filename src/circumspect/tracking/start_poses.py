"""Where registrations start, so that one of them converges to the right minimum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3_matrices
from circumspect.motion import PoseWithCovariance

SPACING = float(np.radians(3.0))
"""Registration converges from rotations that are off by less than this [rad]."""
MAX_STARTS_PER_SIDE = 4
"""So many starts at most on each side of the prediction, within one standard deviation."""


def start_poses(prior: PoseWithCovariance) -> list[NDArray[np.floating]]:
    """Poses that cover the rotations of a prior.

    Args:
        prior: The predicted pose.

    Returns:
        (4, 4) poses, the predicted one first, then others turned about the principal axes of its
        rotation. One alone where its rotation is known to within `SPACING`.
    """
    variances, axes = np.linalg.eigh(prior.covariance[:3, :3])
    starts = [prior.T_map_camera]
    for variance, axis in zip(variances, axes.T, strict=True):
        steps = min(int(np.sqrt(max(variance, 0.0)) / SPACING), MAX_STARTS_PER_SIDE)
        for step in (side * n for n in range(1, steps + 1) for side in (1, -1)):
            turn = se3_matrices.exp(np.concatenate([step * SPACING * axis, np.zeros(3)]))
            starts.append(prior.T_map_camera @ turn)
    return starts
