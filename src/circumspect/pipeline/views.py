"""From which directions the object was seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import wrapped
from circumspect.grid import OccupancyGrid

HALF_VIEW = float(np.radians(45.0))
"""A view shows the sides that face it within this angle [rad]."""
SECTORS = 72


def share_seen(views_xyz: NDArray[np.floating], grid: OccupancyGrid) -> float:
    """Share of the directions around the object's axis that are within 45° of some view.

    Args:
        views_xyz: (f, 3) [m] where frames were taken from.
        grid: The object's grid; its axis is the object's.

    Returns:
        0 without views, 0.25 for a single one, 1 all round.
    """
    if len(views_xyz) == 0:
        return 0.0
    offset = views_xyz[:, :2] - np.asarray(grid.grid.centre_xyz[:2])
    bearings = np.arctan2(offset[:, 1], offset[:, 0])
    sectors = (np.arange(SECTORS) + 0.5) * (2 * np.pi / SECTORS)
    apart = np.abs(wrapped(sectors[:, None] - bearings[None, :]))
    return float((apart.min(axis=1) <= HALF_VIEW).mean())
