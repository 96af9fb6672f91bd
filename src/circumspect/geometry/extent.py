"""Whether points span a shape at all."""

from __future__ import annotations

import numpy as np

from circumspect.errors import GeometryError
from circumspect.geometry import _native
from circumspect.geometry.point_cloud import PointCloud

# A shape thinner than this share of its length, in two directions at once, is a line.
LINE_RATIO = 1e-6


def require_extent(cloud: PointCloud) -> None:
    """Check that the points span at least a plane; any scale and offset will do.

    Raises:
        GeometryError: One point, all points in one place, or all on a line.
    """
    points = cloud.points_xyz
    if len(points) == 1:
        raise GeometryError("has a single point; a shape needs many")
    low, high, scatter = _native.extent(points)
    spread = float((high - low).max())
    if spread <= 16 * np.finfo(np.float64).eps * float(max(-low.min(), high.max())):
        raise GeometryError(f"all {len(points)} points lie in one place; a shape needs an extent")
    deviations = np.sqrt(np.linalg.eigvalsh(scatter).clip(min=0))
    if deviations[1] <= LINE_RATIO * deviations[2]:
        raise GeometryError(f"all {len(points)} points lie on a line; a shape needs a surface")
