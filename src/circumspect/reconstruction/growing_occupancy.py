"""Occupancy grids of an object whose model grows: every ray is traced once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.grid import CylindricalGrid, Grid, OccupancyGrid, hits_views, trace_views
from circumspect.reconstruction import _native
from circumspect.reconstruction.sight_rays import SightRays

MAX_RETRACED_RAYS = 30_000
"""Rays that are traced at once after grids have moved."""


class GrowingOccupancy:
    """Fills the same grids again and again while points and rays are added.

    As long as the grids stay where they are, only new rays are traced; free cells stay free. After
    a change of the grids, or of rays that were traced already, every k-th ray is traced again, so
    that a frame has a bounded cost. `occupancy` is exact, and does not depend on what came before.
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
            InputError: Several grids of another kind, or without a common axis.
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
