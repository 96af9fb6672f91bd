"""Poses at times between those at which they were told."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

NEAR = 0.2
"""What was told further away in time [s] says nothing of where something that moves is."""
APART = 0.5
"""Between two poses no further apart in time [s] the motion is taken as even."""
KEPT = 10.0
"""What was told longer ago is forgotten [s]."""


def between(T_a_before: RigidTransform, T_a_after: RigidTransform, share: float) -> RigidTransform:
    """The pose at a share of the way from one to another, as if the motion was an even screw.

    On the floor that is an arc. Where both are the same, it is exactly that one.

    Args:
        T_a_before: At share 0.
        T_a_after: At share 1.
        share: Of the time.
    """
    if same(T_a_before, T_a_after):
        return T_a_before
    screw = (T_a_before.inv() * T_a_after).as_exp_coords()
    return T_a_before * RigidTransform.from_exp_coords(share * screw)


def same(one: RigidTransform, other: RigidTransform) -> bool:
    """Whether two poses are exactly the same."""
    return np.array_equal(one.as_matrix(), other.as_matrix())
