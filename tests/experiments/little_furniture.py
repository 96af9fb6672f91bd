"""A set of all of ModelNet10's classes that is made in a moment."""

from __future__ import annotations

import numpy as np

from circumspect.datasets import ObjectSet
from circumspect.furniture import CATEGORIES, make_furniture


def furniture(each, first):
    """Equally many objects of all ten classes, whose numbers begin with `first`."""
    pieces = [(label, first + k) for label in range(10) for k in range(each)]
    points = [
        make_furniture(CATEGORIES[label], k).sampled(256, k).points_xyz for label, k in pieces
    ]
    names = np.array([f"{CATEGORIES[label]}_{k:04d}" for label, k in pieces])
    labels = np.array([label for label, _ in pieces])
    return ObjectSet(np.array(points, np.float32), labels, names, CATEGORIES)
