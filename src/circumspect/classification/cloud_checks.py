"""Checks of a cloud before it is named: one object, no floor left, a plausible size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PointCloud

MIN_POINTS = 128
"""Distinct points below which a classifier with an open set never reports `in_distribution`.
Measured by `benchmarks.few_points`: three points are near to some training object, too."""
LAYER = 0.04
"""Thickness of the layer in which the floor is searched, as a share of the object's height."""
MIN_FLOOR_SHARE = 0.05
"""Smallest share of the points in a floor."""
BEYOND = 1.1
"""Smallest radius of a floor, in radii of what stands on it."""
MAX_FLOOR_POINTS = 10_000
"""Number of points in which the floor is searched."""
MIN_LENGTH_M, MAX_LENGTH_M = 0.02, 10.0
"""Plausible range of an object's longest side [m]."""


def is_one_object(points: NDArray[np.float64]) -> bool:
    """Whether a cloud has enough distinct points and no floor beneath.

    Args:
        points: (n, 3).
    """
    return _are_distinct(points, MIN_POINTS) and not holds_floor(points)


def _are_distinct(points: NDArray[np.float64], min_points: int) -> bool:
    """Whether at least `min_points` points are distinct."""
    # The first points of a large cloud are enough, unless they are repeated.
    return any(
        len(np.unique(part, axis=0)) >= min_points for part in (points[: 8 * min_points], points)
    )


def holds_floor(points_xyz: NDArray[np.floating]) -> bool:
    """Whether the lowest layer reaches beyond all that is above it.

    This holds for hardly any of ModelNet10's training objects: a test counts them. Floors that are
    thicker than the layer, by noise or because they lean, are not found.

    Args:
        points_xyz: (n, 3) [m], z up.
    """
    points = points_xyz[:: max(1, len(points_xyz) // MAX_FLOOR_POINTS)]
    heights = points[:, 2]
    low = heights < np.quantile(heights, 0.01) + LAYER * np.ptp(heights)
    if low.mean() < MIN_FLOOR_SHARE or (~low).sum() < MIN_FLOOR_SHARE * len(points):
        return False
    above = points[~low, :2]
    centre = (above.min(axis=0) + above.max(axis=0)) / 2
    reach = np.quantile(np.hypot(*(above - centre).T), 0.98)
    return bool(np.quantile(np.hypot(*(points[low, :2] - centre).T), 0.9) > BEYOND * reach)


def require_plausible_size(cloud: PointCloud) -> None:
    """Refuse sizes that come from a wrong unit.

    Raises:
        InputError: The object is smaller or larger than anything in a room.
    """
    longest = float(max(map(np.ptp, cloud.points_xyz.T)))
    if MIN_LENGTH_M <= longest <= MAX_LENGTH_M:
        return
    digits = ".0f" if longest >= 100.0 else ".3g"
    shown = f"{1e3 * longest:.3g} mm" if longest < 1.0 else f"{longest:{digits}} m"
    raise InputError(
        f"the object would be {shown} long, and {100 * MIN_LENGTH_M:.0f} cm to "
        f"{MAX_LENGTH_M:.0f} m are plausible; check the unit of its points: m, cm, mm or in"
    )
