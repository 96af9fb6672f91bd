"""Where the bounds of an object lie: about its area-weighted centre, as small as holds it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud
from circumspect.grid.grid_arguments import LARGEST_LENGTH


def about_centre(
    cloud: PointCloud,
) -> tuple[NDArray[np.float64], tuple[NDArray[np.float64], ...]]:
    """The area-weighted average of a cloud, x₀ of section 3.2, and its points about it.

    Returns:
        (3,) [m] the centre; (n,) x, y and z [m] of the points from there.

    Raises:
        GeometryError: Coordinates too large for the arithmetic.
    """
    weights = cloud.weights
    centre, about = np.empty(3), []
    # A column at a time, each in one piece: several times faster than rows of three.
    for axis, values in enumerate(np.ascontiguousarray(cloud.points_xyz.T)):
        low, high = values.min(), values.max()
        if max(-low, high) > LARGEST_LENGTH / 4:
            raise GeometryError("points lie beyond 1e49 m; check the unit of the file")
        # Relative to a point of the cloud: far from the origin, sums would lose digits. Clipped:
        # rounding must not put the centre outside the points.
        # Not a dot product: BLAS would wait for its threads longer than the sum takes.
        average = values[0] + (weights * (values - values[0])).sum()
        centre[axis] = min(max(average, low), high)
        about.append(values - centre[axis])
    return centre, tuple(about)


def require_size(cloud: PointCloud, size: float) -> None:
    """Refuse bounds that have no size beside the rounding of the coordinates.

    Raises:
        GeometryError: The points coincide.
    """
    rounding = 8 * np.finfo(np.float64).eps * float(np.abs(cloud.points_xyz).max())
    if not size > max(rounding, 1e-49):
        raise GeometryError(f"all {len(cloud)} points lie in one place; an object has a size")
