"""Occupancy grids of the object: occupied by its surface, free along rays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.grid import Grid, OccupancyGrid, hits_views, trace_views
from circumspect.reconstruction.sight_rays import SightRays


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
        InputError: The grids are of another kind, or do not share their axis.
    """
    states = hits_views(grids, points_xyz)
    if len(rays):
        np.maximum(states, trace_views(grids, rays.origins_xyz, rays.ends_xyz), out=states)
    return [OccupancyGrid(grid, of) for grid, of in zip(grids, states, strict=True)]
