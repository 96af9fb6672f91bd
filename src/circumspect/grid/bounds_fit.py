"""Where the bounds of an object lie: about its area-weighted centre, as small as holds it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud
from circumspect.grid.grid_arguments import LARGEST_LENGTH


def axis_centre(cloud: PointCloud) -> NDArray[np.float64]:
    """The area-weighted average of a cloud, x₀ of section 3.2.

    Returns:
        (3,) [m].

    Raises:
        GeometryError: Coordinates too large for the arithmetic.
    """
    points = cloud.points_xyz
    low, high = points.min(axis=0), points.max(axis=0)
    if max(-low.min(), high.max()) > LARGEST_LENGTH / 4:
        raise GeometryError("points lie beyond 1e49 m; check the unit of the file")
    # Relative to a point of the cloud: far from the origin, sums would lose digits. Clipped:
    # rounding must not put the centre outside the points.
    centre = points[0] + cloud.weights @ (points - points[0])
    return np.clip(centre, low, high)


def require_size(cloud: PointCloud, size: float) -> None:
    """Refuse bounds that have no size beside the rounding of the coordinates.

    Raises:
        GeometryError: The points coincide.
    """
    rounding = 8 * np.finfo(np.float64).eps * float(np.abs(cloud.points_xyz).max())
    if not size > max(rounding, 1e-49):
        raise GeometryError(f"all {len(cloud)} points lie in one place; an object has a size")
