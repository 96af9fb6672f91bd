"""The object's grid: occupied by its surface, free where rays passed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.grid import Grid, OccupancyGrid, hits_views, trace_views
from circumspect.mapping.sight_rays import SightRays


def occupancy(grid: Grid, points_xyz: NDArray[np.floating], rays: SightRays) -> OccupancyGrid:
    """Ray trace what was seen into a grid.

    Args:
        grid: Bounds around the object.
        points_xyz: (n, 3) [m] the object's surface: the ends of beams, equation 3.
        rays: The thinned rays. Where they end says nothing here: those that end on the object
            are in `points_xyz` with less noise, and the floor is not the object.

    Returns:
        Occupied where the surface is, free where rays passed, unknown elsewhere.
    """
    surface = grid.hits(points_xyz)
    if len(rays) == 0:
        return surface
    nothing_hit = np.zeros(len(rays), bool)
    return surface.merged(grid.trace(rays.origins_xyz, rays.ends_xyz, nothing_hit, threads=0))


def occupancies(
    grids: Sequence[Grid], points_xyz: NDArray[np.floating], rays: SightRays
) -> list[OccupancyGrid]:
    """Ray trace what was seen into several grids about one axis, in one pass; see `occupancy`.

    Args:
        grids: Cylindrical grids, the views of an object.
        points_xyz: (n, 3) [m] the object's surface.
        rays: The thinned rays.

    Returns:
        One for each grid.
    """
    states = hits_views(grids, points_xyz)
    if len(rays):
        np.maximum(states, trace_views(grids, rays.origins_xyz, rays.ends_xyz), out=states)
    return [OccupancyGrid(grid, of) for grid, of in zip(grids, states, strict=True)]
