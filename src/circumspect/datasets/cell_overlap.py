"""How much of two objects lies in the same cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from circumspect.classification import GridRecipe
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import GeometryError, InputError

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
        grid = GridRecipe(azimuth_views=1).grids(objects.cloud(index), [0.0])[0, 0]
    except GeometryError as error:
        raise InputError(f"{objects.names[index]}: {error}") from error
    closed = np.concatenate([grid[:, -1:], grid, grid[:, :1]], axis=1)
    near = maximum_filter(closed, size=3)[:, 1:-1]
    return grid.astype(np.float32), near.astype(np.float32)
