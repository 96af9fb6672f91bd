"""Checks of the arguments of grids before they reach the C++ code."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Sequence
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud
from circumspect.geometry.frozen_array import NUMBERS, require_unmasked, rows_of_fields
from circumspect.geometry.given_shapes import refuse_sources
from circumspect.grid import _native

MIN_LENGTH_M, MAX_LENGTH_M = 1e-50, 1e50
"""Range of lengths and coordinates [m]; others would overflow in products."""


def checked_shape(shape: Sequence[int]) -> tuple[int, int, int]:
    """The shape of a grid: three counts of cells.

    Raises:
        InputError: Not three whole numbers, or too many cells for the memory.
    """
    try:
        cells = tuple(operator.index(n) for n in shape)
    except TypeError as error:
        raise InputError(f"a grid's shape is three whole numbers, not {shape!r}") from error
    most = _native.MOST_CELLS_ALONG
    if len(cells) != 3 or not all(1 <= n <= most for n in cells):
        raise InputError(f"a grid's shape is three whole numbers from 1 to {most}, not {cells}")
    if math.prod(cells) > _native.MOST_CELLS:
        raise InputError(f"a grid of {cells} has more than {_native.MOST_CELLS} cells; take fewer")
    return (cells[0], cells[1], cells[2])


def checked_length(value: float, name: str) -> float:
    """A length of a grid [m].

    Raises:
        InputError: Not a positive number, or beyond 1e±50.
    """
    length = checked_number(value, name)
    if not MIN_LENGTH_M <= length <= MAX_LENGTH_M:
        raise InputError(f"{name} must lie between 1e-50 and 1e50 m, not {length:g}")
    return length


def checked_number(value: float, name: str) -> float:
    """A finite number as float.

    Raises:
        InputError: It is not one.
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name} must be a number, not {value!r}") from error
    if not math.isfinite(number):
        raise InputError(f"{name} must be finite, not {number}")
    return number


def checked_centre(centre_xyz: ArrayLike) -> tuple[float, float, float]:
    """The centre of a grid, (3,) [m].

    Raises:
        InputError: Not three finite numbers below 1e50.
    """
    if _is_centre(centre_xyz):
        return centre_xyz
    try:
        centre = np.asarray(centre_xyz, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"a grid's centre is three numbers, not {centre_xyz!r}") from error
    if centre.shape != (3,) or not (np.abs(centre) <= MAX_LENGTH_M).all():
        raise InputError(f"a grid's centre is three numbers within ±1e50 m, not {centre_xyz!r}")
    x, y, z = centre.tolist()
    return (x, y, z)


def _is_centre(given: object) -> TypeGuard[tuple[float, float, float]]:
    """Whether a value is one that `checked_centre` returned, as in copies of a grid."""
    return (
        type(given) is tuple
        and len(given) == 3
        and all(type(c) is float and -MAX_LENGTH_M <= c <= MAX_LENGTH_M for c in given)
    )


def checked_points(points_xyz: PointCloud | ArrayLike, name: str = "points") -> NDArray[Any]:
    """Points as (n, 3) float64 or float32 in C order; copied only if necessary.

    Raises:
        InputError: Wrong shape, not numbers, or a mesh or a path in their place.
        GeometryError: Some are masked.
    """
    if isinstance(points_xyz, PointCloud):
        return points_xyz.points_xyz
    refuse_sources(points_xyz)
    require_unmasked(points_xyz)
    points = np.asarray(rows_of_fields(points_xyz))
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{name} must have shape (n, 3), not {points.shape}")
    if points.dtype not in (np.float32, np.float64):
        if points.dtype.kind not in NUMBERS:
            raise InputError(f"{name} must be real numbers, not {points.dtype}")
        points = points.astype(np.float64)
    if not points.dtype.isnative:
        points = points.astype(points.dtype.newbyteorder("="))
    return np.require(points, requirements=["C", "A"])


def checked_beams(
    origins_xyz: ArrayLike, ends_xyz: PointCloud | ArrayLike
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Origins and ends of beams, (1, 3) or (n, 3), and (n, 3), of one dtype.

    Raises:
        InputError: Wrong shapes, not numbers, or neither one origin nor one for each end.
        GeometryError: Some are masked.
    """
    ends = checked_points(ends_xyz, "ends")
    origins = checked_points(np.atleast_2d(np.asarray(origins_xyz)), "origins")
    if len(origins) not in (1, len(ends)):
        raise InputError(f"{len(origins)} origins for {len(ends)} ends; give one, or one each")
    if origins.dtype != ends.dtype:
        origins, ends = origins.astype(np.float64), ends.astype(np.float64)
    return origins, ends


def require_usable(bad: int, count: int, name: str = "points") -> None:
    """Report points that a kernel found unusable.

    Raises:
        GeometryError: `bad` is not zero.
    """
    if bad:
        raise GeometryError(
            f"{bad} of {count} {name} are NaN, infinite or beyond 1e50 m; remove them first"
        )


def checked_threads(threads: int) -> int:
    """Number of threads; 0 means as many as this process has cores.

    Raises:
        InputError: Negative or not a whole number.
    """
    try:
        wanted = operator.index(threads)
    except TypeError as error:
        raise InputError(f"threads must be a whole number, not {threads!r}") from error
    if wanted < 0:
        raise InputError(f"threads must be 0 (all cores) or more, not {wanted}")
    return min(wanted, 256) or _cores()


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
