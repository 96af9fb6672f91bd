"""From where the object was looked at often enough."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.growing_table import GrowingTable

ENOUGH = 40
"""So many views from about one place show what is to be seen from there. Of a camera that stands
the noise of further ones would add voxels for ever."""
NEAR = 0.1
"""Views within this [m] of each other …"""
ALIKE = float(np.cos(np.radians(12.0)))
"""… and this cosine between their optical axes are from about one place."""


class ViewCrowd:
    """Where frames were taken from that went into a model.

    A camera that goes on is never stopped: of its views those count that are near the next one.
    Where it takes very many on its way they go in by groups, `NEAR` apart.
    """

    def __init__(self) -> None:
        """No view yet."""
        self._views = GrowingTable(6)

    def admits(self, T_map_camera: RigidTransform) -> bool:
        """Whether one more view from there is wanted; if so it counts from now on."""
        matrix = T_map_camera.as_matrix()
        place_xyz, axis = matrix[:3, 3], matrix[:3, 2]
        views = self._views.rows
        alike = views[:, 3:] @ axis >= ALIKE
        near = ((views[:, :3] - place_xyz) ** 2).sum(axis=1) <= NEAR**2
        if np.count_nonzero(alike & near) >= ENOUGH:
            return False
        self._views.append([place_xyz, axis])
        return True
