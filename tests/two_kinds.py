"""Objects of two distinct kinds, and a classifier of them."""

from dataclasses import replace

import numpy as np

from circumspect.classification import GridSpec
from circumspect.datasets import ObjectSet

PLATES_AND_POSTS = ((1.0, 1.0, 0.1), (0.15, 0.15, 1.0))
BEAMS_AND_BOARDS = ((2.0, 0.3, 0.1), (0.3, 0.2, 2.0))
"""Sizes of the flat and the tall kind; these differ along x and y."""


def two_kinds(count=32, points=300, seed=0, classes=("plate", "post"), sizes=PLATES_AND_POSTS):
    """Boxes full of points, flat and tall ones in turn."""
    cube = np.random.default_rng(seed).random((count, points, 3)) - 0.5
    labels = np.arange(count, dtype=np.int64) % 2
    clouds = (cube * np.array(sizes)[labels, None]).astype(np.float32)
    names = np.array([f"{classes[k]}_{i:04d}" for i, k in enumerate(labels)])
    return ObjectSet(clouds, labels, names, classes)


def renamed(objects, prefix):
    """The same objects by other names."""
    return replace(objects, names=np.array([f"{prefix}_{name}" for name in objects.names]))


def flat_and_tall(count):
    """The kinds that `ByHeight` knows."""
    return two_kinds(count, classes=ByHeight.classes, sizes=BEAMS_AND_BOARDS)


class ByHeight:
    """Invariant to yaw: tall objects fill more rows of the grid than flat ones."""

    classes = ("flat", "tall")
    input_spec = GridSpec(azimuth_views=2)

    def probabilities(self, inputs, contexts=None):
        tall = inputs.any(axis=(1, 2, 3, 4)).mean(axis=1)
        return np.stack([1 - tall, tall], axis=1)
