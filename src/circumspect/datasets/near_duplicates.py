"""Which objects of a set are near duplicates of each other.

CAD collections hold families: one sofa in ten variants. Where one is trained on and another is
held back, the held-back one measures memory. ModelNet10's training split is full of them.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter
from scipy.sparse.csgraph import connected_components

from circumspect.classification import GridRecipe
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import GeometryError, InputError

ALIKE = 0.9
"""From this overlap on two objects are near duplicates."""


def near_duplicates(objects: ObjectSet) -> NDArray[np.int64]:
    """Group near duplicates: objects of one class, in the same pose.

    Two objects overlap by the share of the one's occupied cells that lie on or beside those of
    the other, in the default grid; the smaller of both shares counts. Groups are connected
    components, so a group's ends may differ.

    Args:
        objects: The set.

    Returns:
        (n,) the group of each object; groups are numbered from 0.

    Raises:
        InputError: An object spans no shape; the message names it.
    """
    groups, count = np.empty(len(objects), np.int64), 0
    for label in np.unique(objects.labels):
        members = np.flatnonzero(objects.labels == label)
        found, numbers = connected_components(_overlaps(objects, members) >= ALIKE)
        groups[members] = count + numbers
        count += found
    return groups


def _overlaps(objects: ObjectSet, members: NDArray[np.intp]) -> NDArray[np.float32]:
    """(m, m) overlap of each pair, symmetric."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        pairs = list(pool.map(lambda index: _cells(objects, int(index)), members))
    occupied = np.stack([cells for cells, _ in pairs])
    beside = np.stack([near for _, near in pairs])
    shares = occupied @ beside.T / occupied.sum(axis=1, keepdims=True)
    return np.minimum(shares, shares.T)


def _cells(objects: ObjectSet, index: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Occupied cells, and those with their neighbours; flat, 1 or 0."""
    try:
        grid = GridRecipe(azimuth_views=1).grids(objects.cloud(index), [0.0])[0, 0]
    except GeometryError as error:
        raise InputError(f"{objects.names[index]}: {error}") from error
    closed = np.concatenate([grid[:, -1:], grid, grid[:, :1]], axis=1)
    near = maximum_filter(closed, size=3)[:, 1:-1]
    return grid.ravel().astype(np.float32), near.ravel().astype(np.float32)
