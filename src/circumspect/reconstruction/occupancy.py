"""Occupancy grids of the object: occupied by its surface, free along rays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.grid import CylindricalGrid, Grid, OccupancyGrid, hits_views, trace_views
from circumspect.reconstruction import _native
from circumspect.reconstruction.sight_rays import SightRays

MAX_RETRACED_RAYS = 30_000
"""Maximum number of rays that are traced again after the grids moved."""


class GrowingOccupancy:
    """Updates grids incrementally while points and rays are added.

    While the grids do not move, only new rays are traced, and free cells stay free. After a change
    of the grids or of traced rays, every k-th ray is traced again, which bounds the cost of a
    frame. `occupancy` is exact and does not depend on earlier calls.
    """

    def __init__(self) -> None:
        """Start without grids."""
        self._grids: tuple[Grid, ...] = ()
        self._free = np.empty((0, 0, 0, 0), np.uint8)
        self._traced_keys = np.empty(0, np.int64)

    def update(
        self, grids: Sequence[Grid], points_xyz: NDArray[np.floating], rays: SightRays
    ) -> tuple[OccupancyGrid, ...]:
        """Fill the grids.

        Args:
            grids: One grid, or several cylindrical ones around one axis.
            points_xyz: (n, 3) [m] the object's surface.
            rays: All rays so far.

        Returns:
            For each grid: occupied at surface points, free along rays, unknown elsewhere.

        Raises:
            InputError: Several grids are not cylindrical, or do not share their axis.
        """
        new = None
        if tuple(grids) == self._grids:
            new = _native.added_keys(self._traced_keys, rays.keys)
        if new is None:
            self._grids = tuple(grids)
            self._free = _traced(grids, rays.subsampled(MAX_RETRACED_RAYS))
        elif len(new):
            self._free = np.maximum(self._free, _traced(grids, rays[new]))
        self._traced_keys = rays.keys
        states = np.maximum(_hits(grids, points_xyz), self._free)
        return tuple(OccupancyGrid(grid, of) for grid, of in zip(grids, states, strict=True))


def _traced(grids: Sequence[Grid], rays: SightRays) -> NDArray[np.uint8]:
    """(n, *shape) free cells."""
    if isinstance(grids[0], CylindricalGrid):
        return trace_views(grids, rays.origins_xyz, rays.ends_xyz)
    (grid,) = grids
    nothing_hit = np.zeros(len(rays), bool)
    return grid.trace(rays.origins_xyz, rays.ends_xyz, nothing_hit, threads=0).states[None]


def _hits(grids: Sequence[Grid], points_xyz: NDArray[np.floating]) -> NDArray[np.uint8]:
    """(n, *shape) cells with surface."""
    if isinstance(grids[0], CylindricalGrid):
        return hits_views(grids, points_xyz)
    (grid,) = grids
    return grid.hits(points_xyz, threads=0).states[None]


def occupancy(grid: Grid, points_xyz: NDArray[np.floating], rays: SightRays) -> OccupancyGrid:
    """Fill a grid from surface points and rays.

    Args:
        grid: Bounds around the object.
        points_xyz: (n, 3) [m] the object's surface: the ends of beams, equation 3.
        rays: Thinned rays. Their ends occupy no cells: `points_xyz` holds the ends on the object
            with less noise, and the other ends are background.

    Returns:
        Occupied at surface points, free along rays, unknown elsewhere.
    """
    surface = grid.hits(points_xyz)
    if len(rays) == 0:
        return surface
    nothing_hit = np.zeros(len(rays), bool)
    return surface.merged(grid.trace(rays.origins_xyz, rays.ends_xyz, nothing_hit, threads=0))


def occupancies(
    grids: Sequence[Grid], points_xyz: NDArray[np.floating], rays: SightRays
) -> list[OccupancyGrid]:
    """Fill several cylindrical grids around one axis in a single pass; see `occupancy`.

    Args:
        grids: Cylindrical grids with a common axis.
        points_xyz: (n, 3) [m] the object's surface.
        rays: Thinned rays.

    Returns:
        One grid for each of `grids`.

    Raises:
        InputError: The grids are not cylindrical, or do not share their axis.
    """
    states = hits_views(grids, points_xyz)
    if len(rays):
        np.maximum(states, trace_views(grids, rays.origins_xyz, rays.ends_xyz), out=states)
    return [OccupancyGrid(grid, of) for grid, of in zip(grids, states, strict=True)]
