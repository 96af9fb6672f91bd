"""Checked, read-only arrays: what the value types of this package are made of."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError

# Squares and cubes of coordinates up to this stay finite in float64.
LARGEST_COORDINATE = 1e100
NUMBERS = "iuf"
"""NumPy's letters for the kinds of whole and real numbers."""


class ReadOnlyArrays:
    """Base of what holds read-only arrays: those of its copies and pickles are read-only, too.

    NumPy forgets it: without this base every copied array could be written to.
    """

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
        self.__dict__.update(state)


def frozen(values: ArrayLike) -> NDArray[np.float64]:
    """The values as a float64 array that nobody can write to; copied unless that holds already.

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
    """Refuse an array that hides some of its values: they would be used like the others.

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
