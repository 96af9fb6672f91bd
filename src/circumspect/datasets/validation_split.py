"""Which objects of the training split are held back to choose by."""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.near_duplicates import near_duplicates
from circumspect.datasets.object_set import ObjectSet

SHARE = 0.15
"""Of each class held back, where its groups allow it."""
LARGEST = 0.125
"""A group that holds a larger share of its class is trained on."""


def validation_split(objects: ObjectSet, salt: str = "") -> NDArray[np.bool_]:
    """Mark the validation objects: whole groups of near duplicates of each class.

    The large groups of a class are trained on; the others are held back in an order drawn by a
    hash of their names until a share of the class is, or half of them. A class that is one group
    can not be parted so: its objects count as groups of their own. The only object of a class is
    trained on. Scans of one object count as one, and are all on one side.

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
        # Sorted, so that the first scan of an object, which stands for it, is always the same.
        members = members[np.argsort(objects.names[members])]
        _, firsts, of = np.unique(objects.shown[members], return_index=True, return_inverse=True)
        first = members[firsts]
        held_back[members] = _drawn(groups[first], objects.names[first], salt)[of]
    return held_back


def _drawn(groups: NDArray[np.int64], names: NDArray[np.str_], salt: str) -> NDArray[np.bool_]:
    """(m,) the held-back objects of one class."""
    if len(groups) == 1:
        return np.zeros(1, bool)
    if len(np.unique(groups)) == 1:
        groups = np.arange(len(groups))
    _, groups, sizes = np.unique(groups, return_inverse=True, return_counts=True)
    small = np.flatnonzero(sizes <= max(1, LARGEST * len(groups)))
    wanted = min(SHARE * len(groups), sizes[small].sum() / 2)
    order = sorted(small, key=lambda group: _hash(salt + min(names[groups == group].tolist())))
    before = np.cumsum(sizes[order]) - sizes[order]
    return np.isin(groups, np.array(order)[before < wanted])


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()
