"""Many clouds at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud
from circumspect.grid import _native
from circumspect.grid.grid import Grid
from circumspect.grid.grid_arguments import checked_points, checked_threads


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
