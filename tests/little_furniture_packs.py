"""Point packs of all of ModelNet10's classes that are made in a moment."""

from __future__ import annotations

import numpy as np

from circumspect.datasets import ObjectSet
from circumspect.datasets.point_pack import write_point_pack
from circumspect.furniture import CATEGORIES, make_furniture


def write_packs(folder, train=4, test=1):
    """A training and a test pack, with so many objects of each class."""
    folder.mkdir()
    for split, each, first in (("train", train, 0), ("test", test, 500)):
        pieces = [(label, first + k) for label in range(len(CATEGORIES)) for k in range(each)]
        points = [make_furniture(CATEGORIES[label], k).sampled(256, k) for label, k in pieces]
        objects = ObjectSet(
            np.array([cloud.points_xyz for cloud in points], np.float32),
            np.array([label for label, _ in pieces]),
            np.array([f"{CATEGORIES[label]}_{k:04d}" for label, k in pieces]),
            CATEGORIES,
        )
        write_point_pack(folder / f"{split}.npz", objects)
