"""Remove the floor from a scan of an object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.clusters import connected_clusters
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.supporting_plane import (
    SupportingPlane,
    find_supporting_plane,
    thinned,
)

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

MIN_BEYOND = 1.1
"""Smallest radius of a floor, in radii of the object that stands on it."""
MIN_OBJECT_SHARE = 0.02
"""Smallest fraction of the scan's surface in the object."""

_REACH = 0.03
"""Gaps up to this fraction of the scan's diagonal do not split an object."""
_MAX_GAP = 0.15
"""Largest height of the object's lowest point above the floor, as a fraction of its height."""


@dataclass(frozen=True, eq=False)
class FloorCut:
    """Result of cutting a floor.

    Attributes:
        cloud: The object, in the coordinates of the scan.
        plane: The floor.
        kept: (n,) which points of the scan belong to the object.
        floor_points: Number of points in the floor or below.
        other_points: Number of points above it that belong to other things.
    """

    cloud: PointCloud
    plane: SupportingPlane
    kept: NDArray[np.bool_]
    floor_points: int
    other_points: int

    @property
    def tilt(self) -> float:
        """Angle between the floor's normal and the z axis [rad]."""
        return float(np.arccos(np.clip(self.plane.normal_xyz[2], -1.0, 1.0)))

    @property
    def levelling(self) -> Rotation:
        """The smallest rotation that makes the floor horizontal, beneath the object."""
        from circumspect.geometry.resting_poses import rotation_onto_floor

        return rotation_onto_floor(-self.plane.normal_xyz)

    def levelled(self) -> PointCloud:
        """The object, rotated so that the floor is horizontal."""
        from scipy.spatial.transform import RigidTransform

        return self.cloud.moved(RigidTransform.from_rotation(self.levelling))


def cut_floor(
    cloud: PointCloud, *, any_way_up: bool = False, rng: np.random.Generator | int = 0
) -> FloorCut | None:
    """Remove the floor from a scan, and everything else except the object in its middle.

    Args:
        cloud: (n, 3) points of an object and of its floor.
        any_way_up: The floor may have any direction; without it its normal is within 30° of z.
        rng: A generator or a seed, for the search of the plane.

    Returns:
        The object and the removed points; None where no floor is found: no plane that supports the
        rest and extends beyond the object on it.
    """
    up = None if any_way_up else np.array([0.0, 0.0, 1.0])
    plane = find_supporting_plane(cloud.points_xyz, up, rng)
    if plane is None:
        return None
    above = plane.heights(cloud.points_xyz) > plane.tolerance
    kept = _object_on(cloud.points_xyz, above, plane)
    if kept is None:
        return None
    floor = int((~above).sum())
    others = len(cloud) - floor - int(kept.sum())
    return FloorCut(cloud.part(kept), plane, kept, floor, others)


def _object_on(
    points: NDArray[np.float64], above: NDArray[np.bool_], plane: SupportingPlane
) -> NDArray[np.bool_] | None:
    """Mask of the object's points; None if the plane is no floor below it."""
    if not above.any():
        return None
    diagonal = thinned(points)[1]
    clusters = np.full(len(points), -1)
    clusters[above] = connected_clusters(points[above], _REACH * diagonal)
    flat = _in_plane(points, plane.normal_xyz)
    lying = np.abs(plane.heights(points)) <= plane.tolerance
    floor = thinned(points[lying])[0] if lying.any() else points[:0]
    if len(floor) < 3:
        return None
    floor_flat = _in_plane(floor, plane.normal_xyz)
    sizes = np.bincount(clusters[above])
    best = _chosen(sizes, flat, clusters, floor_flat)
    main = clusters == best
    if (
        sizes[best] < MIN_OBJECT_SHARE * len(points)
        and sizes[best] < MIN_OBJECT_SHARE * above.sum()
    ):
        return None
    heights = plane.heights(points[main])
    if heights.min() > _MAX_GAP * heights.max() + plane.tolerance:
        return None
    centre = (flat[main].min(axis=0) + flat[main].max(axis=0)) / 2
    reach = float(np.quantile(np.linalg.norm(flat[main] - centre, axis=1), 0.98))
    beyond = float(np.quantile(np.linalg.norm(floor_flat - centre, axis=1), 0.9))
    if beyond < MIN_BEYOND * reach:
        return None
    # Parts that the cut or thin sampling separated are within the object's footprint.
    kept = main.copy()
    for number in np.flatnonzero(sizes):
        part = clusters == number
        if number != best and np.linalg.norm(np.median(flat[part], axis=0) - centre) < 0.9 * reach:
            kept |= part
    return kept


def _chosen(
    sizes: NDArray[np.int64],
    flat: NDArray[np.float64],
    clusters: NDArray[np.int64],
    floor_flat: NDArray[np.float64],
) -> int:
    """The largest cluster; points at the border of the floor have less weight."""
    centre = floor_flat.mean(axis=0)
    radius = float(np.quantile(np.linalg.norm(floor_flat - centre, axis=1), 0.9)) or 1.0
    scores = sizes.astype(float)
    for number in np.argsort(-sizes)[:20]:
        away = np.linalg.norm(np.median(flat[clusters == number], axis=0) - centre) / radius
        scores[number] *= np.exp(-2.0 * away**2)
    return int(scores.argmax())


def _in_plane(points: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 2) coordinates along two axes of the plane."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first = np.asarray(first / np.linalg.norm(first), np.float64)
    return np.asarray(points @ np.stack([first, np.cross(normal, first)], axis=1), np.float64)
