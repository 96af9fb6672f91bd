"""Several grids in one pass: of many clouds, or all views of one object.

The views of an object differ in azimuth offset, height and size. The radius and the azimuth of a
point are the same in all of them, so they are computed once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud
from circumspect.grid import _native
from circumspect.grid.cylindrical_grid import CylindricalGrid
from circumspect.grid.grid import FREE, OCCUPIED, Grid
from circumspect.grid.grid_arguments import (
    checked_beams,
    checked_number,
    checked_points,
    checked_threads,
    require_usable,
)


def hits_views(
    grids: Sequence[Grid],
    points_xyz: PointCloud | ArrayLike,
    yaw: float = 0.0,
    threads: int = 0,
) -> NDArray[np.uint8]:
    """Occupancy by hits, equation 3, of one cloud in several grids about one axis.

    The states are those of `Grid.hits` for each grid.

    Args:
        grids: n cylindrical grids of one shape whose centres differ in z only.
        points_xyz: (m, 3) [m] the ends of the beams.
        yaw: [rad] the points are turned about the axis by this angle first, counter-clockwise
            seen from above.
        threads: 0 means all cores.

    Returns:
        (n, *shape) uint8 states: `OCCUPIED` where at least one point is, else `UNKNOWN`.

    Raises:
        InputError: No grids, not cylindrical, of several shapes or axes, or wrong shape of points.
        GeometryError: NaN or infinite coordinates.
    """
    kernels, states = _kernels_and_states(grids)
    points, angle = checked_points(points_xyz), checked_number(yaw, "yaw")
    bad = _native.hits_coaxial(kernels, points, angle, states, OCCUPIED, checked_threads(threads))
    require_usable(bad, len(points))
    return states


def trace_views(
    grids: Sequence[Grid],
    origins_xyz: ArrayLike,
    ends_xyz: PointCloud | ArrayLike,
    threads: int = 0,
) -> NDArray[np.uint8]:
    """Free cells by ray tracing of one set of beams in several grids about one axis.

    The states are those of `Grid.trace` for each grid with no beam returned.

    Args:
        grids: n cylindrical grids of one shape whose centres differ in z only.
        origins_xyz: (3,) or (m, 3) [m] where the sensor was.
        ends_xyz: (m, 3) [m] where the beams end.
        threads: 0 means all cores.

    Returns:
        (n, *shape) uint8 states: `FREE` where at least one beam passed, else `UNKNOWN`.

    Raises:
        InputError: No grids, not cylindrical, of several shapes or axes, or wrong shapes of beams.
        GeometryError: NaN or infinite coordinates.
    """
    kernels, states = _kernels_and_states(grids)
    origins, ends = checked_beams(origins_xyz, ends_xyz)
    cores = checked_threads(threads)
    bad = _native.passed_coaxial(kernels, origins, ends, states, FREE, cores)
    require_usable(bad, len(ends), "beams")
    return states


def _kernels_and_states(
    grids: Sequence[Grid],
) -> tuple[list[_native.Cylinder], NDArray[np.uint8]]:
    """The C++ grids, and (n, *shape) unknown states."""
    cylinders: list[CylindricalGrid] = []
    for grid in grids:
        if not isinstance(grid, CylindricalGrid):
            raise InputError(f"views are cylindrical grids, not {type(grid).__name__}")
        cylinders.append(grid)
    if not cylinders:
        raise InputError("no grids were given; at least one is needed")
    shapes = {grid.shape for grid in cylinders}
    if len(shapes) > 1:
        raise InputError(f"views must have one shape, not {sorted(shapes)}")
    axes = {grid.centre_xyz[:2] for grid in cylinders}
    if len(axes) > 1:
        raise InputError(
            f"views must have one axis, not axes at x, y = {sorted(axes)[:2]}; "
            "use hits_batch for grids with several"
        )
    states = np.zeros((len(cylinders), *cylinders[0].shape), np.uint8)
    return [grid.kernels() for grid in cylinders], states


def hits_batch(
    grids: Sequence[Grid], clouds: Sequence[PointCloud | ArrayLike], threads: int = 0
) -> NDArray[np.uint8]:
    """Occupancy by hits of many clouds, equation 3, spread over threads.

    Args:
        grids: n grids of one kind and shape, the n-th around the n-th cloud.
        clouds: n times (m, 3) [m].
        threads: 0 means all cores.

    Returns:
        (n, *shape) uint8, 1 where occupied.

    Raises:
        InputError: Not as many grids as clouds, or of different kinds or shapes.
        GeometryError: A cloud with NaN or infinite coordinates.
    """
    if len(grids) != len(clouds):
        raise InputError(f"{len(grids)} grids for {len(clouds)} clouds; give one each")
    if not grids:
        raise InputError("no grids were given; at least one is needed")
    kinds = {(type(grid).__name__, grid.shape) for grid in grids}
    if len(kinds) > 1:
        raise InputError(f"grids of a batch must be alike, not {sorted(kinds)}")
    points = _of_one_type([checked_points(c, f"cloud {n}") for n, c in enumerate(clouds)])
    states = np.zeros((len(grids), *grids[0].shape), np.uint8)
    bounds = {id(grid): grid.kernels() for grid in grids}
    kernels = [bounds[id(grid)] for grid in grids]
    bad = _native.hits_batch(kernels, points, states, 1, checked_threads(threads))
    if bad >= 0:
        raise GeometryError(f"cloud {bad} has NaN or infinite points; remove them first")
    return states


def _of_one_type(clouds: list[NDArray[Any]]) -> list[NDArray[Any]]:
    if len({cloud.dtype for cloud in clouds}) == 1:
        return clouds
    return [cloud.astype(np.float64, copy=False) for cloud in clouds]
