"""Smallest bounds of an object about its area-weighted centre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud
from circumspect.grid import _native
from circumspect.grid.grid_arguments import MAX_LENGTH_M


@dataclass(frozen=True)
class Reach:
    """Distances of a cloud's points from its area-weighted centre, x₀ of section 3.2.

    Attributes:
        centre_xyz: (3,) [m] the area-weighted average of the points.
        radius: [m] the largest distance from the vertical axis through the centre.
        along_xyz: (3,) [m] the largest distances along x, y and z; x and y are turned by the given
            yaw.
        largest: [m] the largest absolute coordinate.
    """

    centre_xyz: tuple[float, float, float]
    radius: float
    along_xyz: tuple[float, float, float]
    largest: float


def reach_of(cloud: PointCloud, yaw: float = 0.0) -> Reach:
    """The area-weighted centre of a cloud and its points' distances from there.

    Args:
        cloud: (n, 3) points [m].
        yaw: [rad] of the axes x and y along which distances are taken.

    Raises:
        GeometryError: Coordinates too large for the arithmetic.
    """
    weights = None if cloud.areas is None else cloud.weights
    centre, low, high = _native.weighted_centre(cloud.points_xyz, weights)
    largest = max(-min(low), max(high))
    if largest > MAX_LENGTH_M / 4:
        raise GeometryError("points lie beyond 1e49 m; check the unit of the file")
    radius, x, y, z = _native.reach(cloud.points_xyz, centre, yaw)
    return Reach(centre, radius, (x, y, z), largest)


def require_size(cloud: PointCloud, reach: Reach, size: float) -> None:
    """Refuse bounds that are not larger than the rounding of the coordinates.

    Args:
        cloud: (n, 3) points [m].
        reach: Distances of the points from the centre.
        size: [m] of the bounds.

    Raises:
        GeometryError: The points coincide.
    """
    rounding = 8 * np.finfo(np.float64).eps * reach.largest
    if not size > max(rounding, 1e-49):
        raise GeometryError(f"all {len(cloud)} points lie in one place; an object has a size")
