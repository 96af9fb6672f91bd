"""The share of the azimuth from which the object was seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.grid import OccupancyGrid

SECTORS = 72
SECTOR_RAD = 2 * np.pi / SECTORS
"""Width of a sector."""
HALF_VIEW = SECTORS // 8
"""A view shows the sides that face it within 45°: so many sectors to either side."""
FACING = (np.arange(SECTORS)[:, None] + np.arange(1 - HALF_VIEW, 1 + HALF_VIEW)) % SECTORS
"""(72, 18) the borders between sectors that are within 45° of each sector's middle; border k is
where sector k begins."""


def azimuth_coverage(views_xyz: NDArray[np.floating], grid: OccupancyGrid) -> float:
    """Share of the azimuth around the object's axis that is within 45° of some view.

    Args:
        views_xyz: (f, 3) [m] where frames were taken from.
        grid: The object's grid; its axis is the object's.

    Returns:
        0 without views, 0.25 for a single one, 1 all round.
    """
    offset = views_xyz[:, :2] - np.asarray(grid.grid.centre_xyz[:2])
    bearings = np.arctan2(offset[:, 1], offset[:, 0])
    # Views that are nearest to the same border show the same sectors.
    from_border = np.zeros(SECTORS, bool)
    from_border[np.rint(bearings / SECTOR_RAD).astype(np.intp) % SECTORS] = True
    return float(from_border[FACING].any(axis=1).mean())
