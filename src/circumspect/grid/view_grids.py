"""All grids of one object in one pass: cylinders about one axis, its views.

The views of an object differ in azimuth offset, height and size. The radius and the azimuth of a
point are the same in all of them, so they are computed once.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.grid import _native
from circumspect.grid.cylindrical_grid import CylindricalGrid
from circumspect.grid.grid import Grid
from circumspect.grid.grid_arguments import (
    checked_beams,
    checked_number,
    checked_points,
    checked_threads,
    require_usable,
)
from circumspect.grid.occupancy_grid import FREE, OCCUPIED


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
