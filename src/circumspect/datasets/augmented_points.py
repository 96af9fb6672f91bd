"""Augmented points of a set: made for each batch, for they are quick to make and large to keep."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import PointsRecipe
from circumspect.datasets.augmented_clouds import AugmentedClouds


class AugmentedPoints:
    """Random variants of each object, as points.

    Args:
        clouds: The variants.
        recipe: How many points, and whether from all of the surface.
    """

    def __init__(self, clouds: AugmentedClouds, recipe: PointsRecipe) -> None:
        self._clouds, self._recipe = clouds, recipe
        self._pool = ThreadPoolExecutor(os.cpu_count())

    def batch(self, objects: NDArray[np.int64], replicas: NDArray[np.int64]) -> NDArray[np.float32]:
        """Points of chosen objects.

        Args:
            objects: (b,) indices into the set.
            replicas: (b,) the variant of each.

        Returns:
            (b, count, 3) float32.
        """
        return np.stack(list(self._pool.map(self._one, objects.tolist(), replicas.tolist())))

    def _one(self, index: int, replica: int) -> NDArray[np.float32]:
        samples = self._clouds.samples(index, replica)
        return self._recipe.of_samples(samples, np.random.default_rng([index, replica]))
