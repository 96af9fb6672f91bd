"""A scene as a plan view shows it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.simulation.scene import Scene

NO_OBSTACLE = ("floor", "object")


def outlines(scene: Scene) -> tuple[NDArray[np.float64], ...]:
    """Convex outlines, seen from above, of all surfaces but the floor and the object.

    Args:
        scene: What stands around.

    Returns:
        Closed polygons, each (k, 2) [m] with the first corner repeated at the end.

    Raises:
        GeometryError: A surface has no width from above.
    """
    from scipy.spatial import ConvexHull, QhullError

    found = []
    for surface in scene.surfaces:
        if surface.name in NO_OBSTACLE:
            continue
        points = surface.mesh.vertices_xyz[:, :2]
        try:
            corners = points[ConvexHull(points).vertices]
        except QhullError as error:
            raise GeometryError(f"the surface '{surface.name}' has no width from above") from error
        found.append(np.vstack([corners, corners[:1]]))
    return tuple(found)
