"""Interpolation of poses in time."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

MAX_STAMP_DISTANCE_S = 0.2
"""Maximum time between a query and the nearest pose of a moving frame [s]."""
MAX_INTERPOLATION_GAP_S = 0.5
"""Maximum time between two poses that are interpolated [s]."""
HISTORY_S = 10.0
"""Duration of the history that is kept [s]."""


def interpolated(
    T_a_before: RigidTransform, T_a_after: RigidTransform, fraction: float
) -> RigidTransform:
    """Interpolate between two poses along a screw motion, which is an arc on the floor.

    Identical poses are returned unchanged.

    Args:
        T_a_before: Pose at fraction 0.
        T_a_after: Pose at fraction 1.
        fraction: Fraction of the time between them.
    """
    if is_same_pose(T_a_before, T_a_after):
        return T_a_before
    screw = (T_a_before.inv() * T_a_after).as_exp_coords()
    return T_a_before * RigidTransform.from_exp_coords(fraction * screw)


def is_same_pose(one: RigidTransform, other: RigidTransform) -> bool:
    """Whether two poses are exactly equal."""
    return np.array_equal(one.as_matrix(), other.as_matrix())
