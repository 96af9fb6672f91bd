"""Data sets for commands that train."""

import numpy as np
import pytest

from circumspect.datasets import ObjectSet
from circumspect.datasets.point_pack import write_point_pack
from circumspect.furniture import make_furniture


@pytest.fixture(scope="session")
def data(tmp_path_factory):
    """Chairs and sofas as point packs."""
    folder = tmp_path_factory.mktemp("data")
    classes = ("chair", "sofa")
    for split, count in (("train", 40), ("test", 6)):
        labels = np.arange(count) % 2
        pieces = [make_furniture(classes[k], 50 + i) for i, k in enumerate(labels)]
        points = np.stack([piece.sampled(400, 0).points_xyz for piece in pieces])
        names = np.array([f"{split}_{classes[k]}_{i:04d}" for i, k in enumerate(labels)])
        objects = ObjectSet(points.astype(np.float32), labels.astype(np.int64), names, classes)
        write_point_pack(folder / f"{split}.npz", objects)
    return folder
