"""Which objects of a set are near duplicates of each other.

CAD collections hold families: one sofa in ten variants. Where one is trained on and another is
held back, the held-back one measures memory. ModelNet10's training split is full of them. Gathered
sets hold several scans of one object, each in the frame of its own robot.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from circumspect.datasets.cell_overlap import ALIKE, occupied_and_beside
from circumspect.datasets.object_set import ObjectSet


def near_duplicates(objects: ObjectSet) -> NDArray[np.int64]:
    """Group near duplicates: objects of one class, in the same pose, and scans of one object.

    Those are near duplicates that overlap by `ALIKE`, see `occupied_and_beside`; scans of one
    object are in any pose. Groups are connected components, so a group's ends may differ.

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
