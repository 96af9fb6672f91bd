"""Points whose coordinates are named fields, as ROS and PCL hand them over."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from circumspect.errors import GeometryError
from circumspect.geometry.frozen_array import NUMBERS, require_unmasked

_AXES = ("x", "y", "z")


def rows_of_fields(points: ArrayLike) -> ArrayLike:
    """Fields x, y and z as rows; what has no fields as it is.

    Args:
        points: Structured, of any shape; fields beside x, y and z are passed over.

    Returns:
        (n, 3), copied, in the type of the fields.

    Raises:
        GeometryError: A field is missing or no single number, or values are masked.
    """
    if not isinstance(points, np.ndarray) or points.dtype.kind != "V":
        return points
    require_unmasked(points)
    fields = points.dtype.fields or {}
    if any(axis not in fields or fields[axis][0].kind not in NUMBERS for axis in _AXES):
        raise GeometryError(f"numbers are needed in fields x, y and z, not {points.dtype}")
    return np.stack([np.ravel(points[axis]) for axis in _AXES], axis=1)
