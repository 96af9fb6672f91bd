"""Centres of cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.grid.cylindrical_grid import CylindricalGrid
from circumspect.grid.grid import OccupancyGrid
from circumspect.grid.rectangular_grid import RectangularGrid


def occupied_centres(grid: OccupancyGrid) -> NDArray[np.float64]:
    """The centre of each occupied cell.

    Returns:
        (n, 3) [m], in the order of `np.argwhere(grid.occupied)`.

    Raises:
        InputError: An unknown kind of grid.
    """
    bounds = grid.grid
    shares = (np.argwhere(grid.occupied) + 0.5) / bounds.shape
    if isinstance(bounds, CylindricalGrid):
        radii = shares[:, 0] * bounds.radius
        azimuths = shares[:, 1] * 2.0 * np.pi + bounds.azimuth_offset
        heights = (2.0 * shares[:, 2] - 1.0) * bounds.half_height
        offsets = np.stack([radii * np.cos(azimuths), radii * np.sin(azimuths), heights], axis=1)
    elif isinstance(bounds, RectangularGrid):
        across, along, up = ((2.0 * shares - 1.0) * bounds.half_width).T
        cosine, sine = np.cos(bounds.yaw), np.sin(bounds.yaw)
        turned = (cosine * across - sine * along, sine * across + cosine * along, up)
        offsets = np.stack(turned, axis=1)
    else:
        raise InputError(f"no centres are known for a grid of type {type(bounds).__name__}")
    return offsets + np.asarray(bounds.centre_xyz)
