"""Checked, read-only arrays for the value types of this package."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError

# Squares and cubes of coordinates up to this stay finite in float64.
MAX_COORDINATE = 1e100
NUMBERS = "iuf"
"""NumPy's letters for the kinds of whole and real numbers."""
_AXES = ("x", "y", "z")


class ReadOnlyArrays:
    """Base of classes with read-only arrays, which stay read-only in copies and pickles.

    NumPy does not keep the flag in copies.
    """

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
        self.__dict__.update(state)


def frozen(values: ArrayLike) -> NDArray[np.float64]:
    """The values as a read-only float64 array; copied unless it is one already.

    Raises:
        GeometryError: They are not whole or real numbers, some are masked, or not of one shape.
    """
    if (
        isinstance(values, np.ndarray)
        and values.dtype == np.float64
        and values.base is None
        and not values.flags.writeable
    ):
        return values
    require_unmasked(values)
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"an array of numbers is needed: {error}") from error
    if array.dtype.kind not in NUMBERS:
        given = type(values).__name__ if array.dtype == object else f"one of {array.dtype}"
        raise GeometryError(f"an array of numbers is needed, not {given}")
    array = np.array(array, dtype=np.float64, order="C")
    array.flags.writeable = False
    return array


def require_unmasked(values: object) -> None:
    """Refuse masked values, which would be used like the others.

    Raises:
        GeometryError: Some are masked.
    """
    if not isinstance(values, np.ma.MaskedArray):
        return
    if np.ma.flatten_mask(np.ma.getmaskarray(values)).any():
        raise GeometryError("the array has masked values; drop masked rows first")


def require_coordinates(points_xyz: NDArray[np.float64], what: str) -> None:
    """Check shape (n, 3) and that all coordinates are finite and of usable size.

    Raises:
        GeometryError: They are not; the message counts the bad ones.
    """
    if points_xyz.ndim != 2 or points_xyz.shape[1] != 3:
        raise GeometryError(f"{what} must have shape (n, 3), not {points_xyz.shape}")
    if len(points_xyz) == 0:
        raise GeometryError(f"there are no {what}; at least one is needed")
    # One pass: NaN fails every comparison.
    low, high = float(points_xyz.min()), float(points_xyz.max())
    if low >= -MAX_COORDINATE and high <= MAX_COORDINATE:
        return
    bad = int(np.count_nonzero(~np.isfinite(points_xyz).all(axis=1)))
    if bad:
        raise GeometryError(
            f"{bad} of {len(points_xyz)} {what} are NaN or infinite; remove them first"
        )
    raise GeometryError(
        f"{what} have coordinates beyond {MAX_COORDINATE:g}; check the file or its unit"
    )


def rows_of_fields(points: ArrayLike) -> ArrayLike:
    """Fields x, y and z as rows; arrays without fields are returned unchanged.

    Args:
        points: Structured, of any shape; further fields are ignored.

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
