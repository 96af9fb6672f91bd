"""Where the bounds of an object lie: about its area-weighted centre, as small as holds it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud
from circumspect.grid import _native
from circumspect.grid.grid_arguments import LARGEST_LENGTH


@dataclass(frozen=True)
class Reach:
    """How far the points of a cloud are from its area-weighted centre, x₀ of section 3.2.

    Attributes:
        centre_xyz: (3,) [m] the area-weighted average of the points.
        radius: [m] the largest distance from the vertical axis through the centre.
        along_xyz: (3,) [m] the largest distances along x, y and z, x and y turned by the yaw that
            was asked for.
        largest: [m] the largest absolute coordinate.
    """

    centre_xyz: tuple[float, float, float]
    radius: float
    along_xyz: tuple[float, float, float]
    largest: float


def reach_of(cloud: PointCloud, yaw: float = 0.0) -> Reach:
    """The area-weighted centre of a cloud and how far its points are from there.

    Args:
        cloud: (n, 3) points [m].
        yaw: [rad] of the axes x and y along which distances are taken.

    Raises:
        GeometryError: Coordinates too large for the arithmetic.
    """
    weights = None if cloud.areas is None else cloud.weights
    centre, low, high = _native.weighted_centre(cloud.points_xyz, weights)
    largest = max(-min(low), max(high))
    if largest > LARGEST_LENGTH / 4:
        raise GeometryError("points lie beyond 1e49 m; check the unit of the file")
    radius, x, y, z = _native.reach(cloud.points_xyz, centre, yaw)
    return Reach(centre, radius, (x, y, z), largest)


def require_size(cloud: PointCloud, reach: Reach, size: float) -> None:
    """Refuse bounds that have no size beside the rounding of the coordinates.

    Args:
        cloud: (n, 3) points [m].
        reach: How far they are from their centre.
        size: [m] of the bounds.

    Raises:
        GeometryError: The points coincide.
    """
    rounding = 8 * np.finfo(np.float64).eps * reach.largest
    if not size > max(rounding, 1e-49):
        raise GeometryError(f"all {len(cloud)} points lie in one place; an object has a size")
