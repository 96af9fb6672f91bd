"""Augmented clouds of a set: any number of variants of each object."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.input_recipe import turned
from circumspect.datasets.augmentation import Augmentation
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import GeometryError
from circumspect.geometry import short_edge_triangles

TRIANGLES = 10_000
"""Samples drawn on the surface of each variant."""


class AugmentedClouds:
    """Random variants of each object, made when they are asked for.

    Args:
        objects: The set.
        augmentation: The random changes.
        seed: Of all chance; a variant depends on it, the object and the replica alone.
        filled: Samples lie between the points as well.
        random_yaw: Every variant is turned about the vertical by an angle of its own. The variants
            are otherwise the same as without it.
    """

    def __init__(
        self,
        objects: ObjectSet,
        augmentation: Augmentation,
        seed: int,
        filled: bool = True,
        random_yaw: bool = False,
    ) -> None:
        self.objects, self.augmentation, self.seed = objects, augmentation, seed
        self.random_yaw = random_yaw
        self._filled = filled

    def __len__(self) -> int:
        return len(self.objects)

    def samples(self, index: int, replica: int) -> NDArray[np.float32]:
        """(m, 3) samples of one variant, see `Augmentation.apply`."""
        rng = np.random.default_rng([self.seed, replica, index])
        samples = self.augmentation.apply(
            self.objects.points_xyz[index], self._surfaces[index], rng
        )
        # The angle is drawn last, and only when it is used: the other draws stay as they are.
        return _turned(samples, rng.uniform(0.0, 2 * np.pi)) if self.random_yaw else samples

    @cached_property
    def _surfaces(self) -> list[NDArray[np.int32]]:
        if not self._filled:
            return [np.empty((0, 3), np.int32)] * len(self.objects)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return list(pool.map(_surface, self.objects.points_xyz))


def _turned(samples_xyz: NDArray[np.float32], yaw: float) -> NDArray[np.float32]:
    """(m, 3) samples turned by an angle [rad] about the z axis, counter-clockwise from above."""
    return turned(samples_xyz.astype(np.float64), yaw).astype(np.float32)


def _surface(points_xyz: NDArray[np.float32]) -> NDArray[np.int32]:
    """(t, 3) triangles between near points, chosen by area."""
    try:
        mesh = short_edge_triangles(points_xyz)
        return mesh.faces[mesh.chosen_by_area(TRIANGLES)].astype(np.int32)
    except GeometryError:
        return np.empty((0, 3), np.int32)
