"""How much of two objects lies in the same cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from circumspect.classification import GridRecipe
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud

ALIKE = 0.9
"""From this overlap on two objects are near duplicates."""


def occupied_and_beside(
    objects: ObjectSet, index: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """An object's occupied cells in the default grid at 0°, and those with their neighbours.

    Two objects overlap by the share of the one's occupied cells that lie on or beside those of
    the other; the smaller of both shares counts.

    Args:
        objects: The set.
        index: Of the object.

    Returns:
        Both (radius, azimuth, height), 1 or 0.

    Raises:
        InputError: The object spans no shape; the message names it.
    """
    try:
        return cells_and_beside(objects.cloud(index))
    except GeometryError as error:
        raise InputError(f"{objects.names[index]}: {error}") from error


def cells_and_beside(cloud: PointCloud) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The same of one cloud.

    Raises:
        GeometryError: The cloud spans no shape.
    """
    grid = GridRecipe(azimuth_views=1).grids(cloud, [0.0])[0, 0]
    closed = np.concatenate([grid[:, -1:], grid, grid[:, :1]], axis=1)
    near = maximum_filter(closed, size=3)[:, 1:-1]
    return grid.astype(np.float32), near.astype(np.float32)


def turned(cells: NDArray[np.float32], every: int = 1) -> NDArray[np.float32]:
    """Cells at whole cells of azimuth.

    Args:
        cells: (radius, azimuth, height).
        every: Turned by so many cells at a time.

    Returns:
        (turns, cells), the first one as given.
    """
    steps = range(0, cells.shape[1], every)
    return np.stack([np.roll(cells, step, axis=1).ravel() for step in steps])
