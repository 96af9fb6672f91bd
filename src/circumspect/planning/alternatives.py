"""The same view from a little nearer or further off."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.planning.next_view import NextView
from circumspect.planning.stance import camera_place, stance

OFFSETS = (0.15, -0.15, 0.3, -0.3, 0.5)
"""Tried one after the other [m]; positive is further off."""
NEAREST = 0.6
"""No nearer than this does the camera come to what it looks at [m]."""


def alternatives(view: NextView, T_base_camera: RigidTransform) -> Iterator[NextView]:
    """Views along the same line of sight, for when there is no way to the wanted one.

    Args:
        view: The wanted view.
        T_base_camera: Where the camera is mounted.
    """
    target = np.asarray(view.looks_at_xy)
    sight = camera_place(view.T_map_base, T_base_camera).xy - target
    distance = float(np.linalg.norm(sight))
    for offset in OFFSETS:
        if distance + offset >= NEAREST:
            place = target + sight * (1 + offset / distance)
            base = stance(place, target, T_base_camera)
            way = "further off" if offset > 0 else "nearer"
            why = f"{view.why}, but {abs(offset):.2f} m {way}"
            yield NextView(base, view.looks_at_xy, view.normal_xy, why)
