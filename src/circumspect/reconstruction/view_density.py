"""The density of viewpoints from which frames were fused."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.growing_table import GrowingTable

MAX_SIMILAR_VIEWS = 40
"""Maximum number of views accepted from one viewpoint. More noise would keep adding voxels."""
SIMILAR_DISTANCE_M = 0.1
"""Similar views are at most this far apart [m]."""
MIN_SIMILAR_COSINE = float(np.cos(np.radians(12.0)))
"""Cosine of the largest angle between the optical axes of similar views."""


class ViewDensity:
    """Limits the number of fused views per viewpoint.

    Two views are similar if they are at most `SIMILAR_DISTANCE_M` and 12° apart. The density at a
    view is the number of accepted views that are similar to it. A moving camera is never blocked;
    a slow one has its views accepted in groups that are `SIMILAR_DISTANCE_M` apart.
    """

    def __init__(self) -> None:
        """Start without views."""
        self._views = GrowingTable(6)

    def accept(self, T_map_camera: RigidTransform) -> bool:
        """Record a view unless `MAX_SIMILAR_VIEWS` similar ones are recorded already.

        Returns:
            True if the view was recorded.
        """
        matrix = T_map_camera.as_matrix()
        position_xyz, axis = matrix[:3, 3], matrix[:3, 2]
        views = self._views.rows
        aligned = views[:, 3:] @ axis >= MIN_SIMILAR_COSINE
        near = ((views[:, :3] - position_xyz) ** 2).sum(axis=1) <= SIMILAR_DISTANCE_M**2
        if np.count_nonzero(aligned & near) >= MAX_SIMILAR_VIEWS:
            return False
        self._views.append([position_xyz, axis])
        return True
