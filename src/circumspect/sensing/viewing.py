"""Where a camera looks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError


def looking(place_xyz: ArrayLike, pan: float, tilt: float) -> RigidTransform:
    """The pose of an upright camera, optical frame, by where it stands and looks.

    Args:
        place_xyz: (3,) [m].
        pan: Counter-clockwise from the frame's x axis [rad].
        tilt: How far down [rad], within ±π/2.

    Raises:
        InputError: A value is not finite, or the camera looks straight up or down.
    """
    place = np.asarray(place_xyz, np.float64)
    if not np.isfinite([*place, pan]).all() or not abs(tilt) < np.pi / 2:
        raise InputError(
            f"a camera at {place.tolist()} that looks {np.degrees(tilt):.0f}° down; give finite "
            "values and a tilt within 90°"
        )
    c, s = np.cos([pan, tilt]), np.sin([pan, tilt])
    forward = np.array([c[1] * c[0], c[1] * s[0], -s[1]])
    right = np.array([s[0], -c[0], 0.0])
    axes = np.column_stack([right, np.cross(forward, right), forward])
    return RigidTransform.from_components(place, Rotation.from_matrix(axes))
