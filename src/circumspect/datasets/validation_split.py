"""The validation split: training objects that are held back for model selection.

CAD collections contain families, such as one sofa in ten variants. If one variant is trained on and
another is held back, the held-back one measures memorisation. ModelNet10's training split has many
families. Gathered sets contain several scans of one object, each in the frame of its own robot.
"""

from __future__ import annotations

import hashlib
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter
from scipy.sparse.csgraph import connected_components

from circumspect.classification import GridSpec
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud

SHARE = 0.15
"""Fraction of each class that is held back, if its groups allow it."""
MAX_GROUP_SHARE = 0.125
"""Maximum fraction of a class in a held-back group; larger groups are trained on."""
ALIKE = 0.9
"""Minimum overlap of near duplicates."""


def validation_split(objects: ObjectSet, salt: str = "") -> NDArray[np.bool_]:
    """Mark the validation objects: whole groups of near duplicates of each class.

    The large groups of a class are trained on. The small ones are held back, in the order of a hash
    of their names, until they make up `SHARE` of the class or half of the objects in small groups.
    In a class with a single group, every object is its own group. The only object of a class is
    trained on. Scans of one object count as one and are in the same part.

    Args:
        objects: The set.
        salt: Another salt gives another split.

    Returns:
        (n,) True for validation.

    Raises:
        InputError: An object spans no shape.
    """
    held_back = np.zeros(len(objects), bool)
    groups = near_duplicates(objects)
    for label in np.unique(objects.labels):
        members = np.flatnonzero(objects.labels == label)
        # Sorted, so that the same scan always represents an object.
        members = members[np.argsort(objects.names[members])]
        _, firsts, of = np.unique(objects.shown[members], return_index=True, return_inverse=True)
        first = members[firsts]
        held_back[members] = _drawn(groups[first], objects.names[first], salt)[of]
    return held_back


def _drawn(groups: NDArray[np.int64], names: NDArray[np.str_], salt: str) -> NDArray[np.bool_]:
    """(m,) whether each object of one class is held back."""
    if len(groups) == 1:
        return np.zeros(1, bool)
    if len(np.unique(groups)) == 1:
        groups = np.arange(len(groups))
    _, groups, sizes = np.unique(groups, return_inverse=True, return_counts=True)
    small = np.flatnonzero(sizes <= max(1, MAX_GROUP_SHARE * len(groups)))
    wanted = min(SHARE * len(groups), sizes[small].sum() / 2)
    order = sorted(small, key=lambda group: _hash(salt + min(names[groups == group].tolist())))
    before = np.cumsum(sizes[order]) - sizes[order]
    return np.isin(groups, np.array(order)[before < wanted])


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()


def near_duplicates(objects: ObjectSet) -> NDArray[np.int64]:
    """Group near duplicates: objects of one class, in the same pose, and scans of one object.

    Objects that overlap by `ALIKE` are near duplicates, see `occupied_and_beside`; scans of one
    object may have any pose. Groups are connected components, so that not all pairs in a group are
    near duplicates.

    Args:
        objects: The set.

    Returns:
        (n,) group of each object, numbered from 0.

    Raises:
        InputError: An object spans no shape; the message names it.
    """
    groups, count = np.empty(len(objects), np.int64), 0
    for label in np.unique(objects.labels):
        members = np.flatnonzero(objects.labels == label)
        _, shown = np.unique(objects.shown[members], return_inverse=True)
        alike = (_overlaps(objects, members) >= ALIKE) | (shown[:, None] == shown)
        found, numbers = connected_components(alike)
        groups[members] = count + numbers
        count += found
    return groups


def _overlaps(objects: ObjectSet, members: NDArray[np.intp]) -> NDArray[np.float32]:
    """(m, m) overlap of each pair, symmetric."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        pairs = list(pool.map(lambda index: occupied_and_beside(objects, int(index)), members))
    occupied = np.stack([cells.ravel() for cells, _ in pairs])
    beside = np.stack([near.ravel() for _, near in pairs])
    shares = occupied @ beside.T / occupied.sum(axis=1, keepdims=True)
    return np.minimum(shares, shares.T)


def occupied_and_beside(
    objects: ObjectSet, index: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """An object's occupied cells in the default grid at 0°, without and with neighbours.

    The overlap of two objects is the fraction of one's occupied cells on or beside those of the
    other; the smaller of both fractions counts.

    Args:
        objects: The set.
        index: Index of the object.

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
    """See `occupied_and_beside`, for one cloud.

    Raises:
        GeometryError: The cloud spans no shape.
    """
    grid = GridSpec(azimuth_views=1).grids(cloud, [0.0])[0, 0]
    closed = np.concatenate([grid[:, -1:], grid, grid[:, :1]], axis=1)
    near = maximum_filter(closed, size=3)[:, 1:-1]
    return grid.astype(np.float32), near.astype(np.float32)


def turned(cells: NDArray[np.float32], every: int = 1) -> NDArray[np.float32]:
    """Cells rolled by whole cells of azimuth.

    Args:
        cells: (radius, azimuth, height).
        every: Step between rolls [cells].

    Returns:
        (turns, cells); the first turn is 0.
    """
    steps = range(0, cells.shape[1], every)
    return np.stack([np.roll(cells, step, axis=1).ravel() for step in steps])
