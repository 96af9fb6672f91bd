"""Poses in which an object can rest on the floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from circumspect.geometry.point_cloud import PointCloud, require_extent

ALIKE = np.cos(np.deg2rad(8.0))
"""Faces of the hull with a smaller angle between normals are one: sampled planes are not quite
flat."""

NEARLY = 0.1
"""Largest height above the floor of the hull below the centre, in units of half the object's
size. Surfaces locate the mass only roughly."""

SMALL = 0.02
"""Faces below this fraction of the largest one are rounded edges."""


def resting_poses(cloud: PointCloud, max_poses: int = 8) -> list[Rotation]:
    """Rotations that put an object on a face of its convex hull, its centre above that face.

    Man-made objects stand on such a face (Fu et al., "Upright orientation of man-made objects",
    SIGGRAPH 2008); the caller chooses among them.

    Args:
        cloud: (n, 3) points of the object, any axis up.
        max_poses: Largest number of rotations; those on the largest faces come first.

    Returns:
        Rotations from the cloud's coordinates to those of the standing object, z up. A flat cloud
        has both sides.

    Raises:
        GeometryError: The points span no shape.
    """
    require_extent(cloud)
    points = cloud.points_xyz - cloud.points_xyz.mean(axis=0)
    points = points / np.abs(points).max()
    centre = np.average(points, axis=0, weights=cloud.weights)
    try:
        hull = ConvexHull(points)
    except QhullError:
        normal = np.linalg.svd(points, full_matrices=False)[2][2]
        return [rotation_onto_floor(normal), rotation_onto_floor(-normal)][:max_poses]
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    a, b, c = points[hull.simplices].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    found = []
    left = np.ones(len(areas), bool)
    for first in np.argsort(-areas):
        if not left[first]:
            continue
        face = left & (normals @ normals[first] > ALIKE)
        left &= ~face
        normal = areas[face] @ normals[face]
        normal /= np.linalg.norm(normal)
        below = centre + normal * _way_out(normals, offsets, centre, normal)
        lowest = (points @ normal).max()
        if lowest - below @ normal < NEARLY:
            found.append((areas[face].sum(), normal))
    found.sort(key=lambda one: -one[0])
    large = [normal for area, normal in found if area > SMALL * found[0][0]]
    return [rotation_onto_floor(normal) for normal in large[:max_poses]]


def _way_out(
    normals: NDArray[np.float64],
    offsets: NDArray[np.float64],
    start: NDArray[np.float64],
    direction: NDArray[np.float64],
) -> float:
    """Distance from a point inside to the hull."""
    along = normals @ direction
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.where(along > 1e-12, -(normals @ start + offsets) / along, np.inf)
    return float(away.min())


def rotation_onto_floor(normal: NDArray[np.float64]) -> Rotation:
    """The smallest rotation that turns a direction downwards.

    Args:
        normal: (3,) unit vector.
    """
    down = np.array([0.0, 0.0, -1.0])
    axis = np.cross(normal, down)
    sine, cosine = float(np.linalg.norm(axis)), float(normal @ down)
    if sine < 1e-12:
        return Rotation.identity() if cosine > 0 else Rotation.from_rotvec([np.pi, 0.0, 0.0])
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine))
