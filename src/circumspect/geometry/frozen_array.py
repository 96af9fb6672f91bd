"""Checked, read-only arrays: what the value types of this package are made of."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError

# Squares and cubes of coordinates up to this stay finite in float64.
LARGEST_COORDINATE = 1e100


def frozen(values: ArrayLike) -> NDArray[np.float64]:
    """The values as a float64 array that nobody can write to; copied unless that holds already.

    Raises:
        GeometryError: They are not numbers, or not of one shape.
    """
    if (
        isinstance(values, np.ndarray)
        and values.dtype == np.float64
        and values.base is None
        and not values.flags.writeable
    ):
        return values
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise GeometryError(f"an array of numbers is needed: {error}") from error
    array.flags.writeable = False
    return array


def require_coordinates(points_xyz: NDArray[np.float64], what: str) -> None:
    """Check shape (n, 3) and that all coordinates are finite and of usable size.

    Raises:
        GeometryError: They are not; the message counts the bad ones.
    """
    if points_xyz.ndim != 2 or points_xyz.shape[1] != 3:
        raise GeometryError(f"{what} must have shape (n, 3), not {points_xyz.shape}")
    if len(points_xyz) == 0:
        raise GeometryError(f"there are no {what}; at least one is needed")
    # One pass over the numbers: NaN fails every comparison.
    low, high = float(points_xyz.min()), float(points_xyz.max())
    if low >= -LARGEST_COORDINATE and high <= LARGEST_COORDINATE:
        return
    bad = int(np.count_nonzero(~np.isfinite(points_xyz).all(axis=1)))
    if bad:
        raise GeometryError(
            f"{bad} of {len(points_xyz)} {what} are NaN or infinite; remove them first"
        )
    raise GeometryError(
        f"{what} have coordinates beyond {LARGEST_COORDINATE:g}; check the file or its unit"
    )
