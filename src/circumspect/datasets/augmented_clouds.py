"""Augmented clouds of a set: any number of variants of each object."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridSpec, PointsSpec
from circumspect.classification.input_spec import turned
from circumspect.datasets.augmentation import Augmentation
from circumspect.datasets.grid_cache import GridCache, PackedGrids
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import GeometryError
from circumspect.geometry import short_edge_triangles
from circumspect.grid import hits_batch

TRIANGLES = 10_000
"""Samples drawn on the surface of each variant."""
Progress = Callable[[int, int], None]


class AugmentedPoints:
    """Random variants of each object, as points.

    Args:
        clouds: The variants.
        input_spec: Number of points, and whether they cover the whole surface.
    """

    def __init__(self, clouds: AugmentedClouds, input_spec: PointsSpec) -> None:
        self._clouds, self._input_spec = clouds, input_spec
        self._pool = ThreadPoolExecutor(os.cpu_count())

    def batch(self, objects: NDArray[np.int64], replicas: NDArray[np.int64]) -> NDArray[np.float32]:
        """The points of some variants.

        Args:
            objects: (b,) indices into the set.
            replicas: (b,) the variant of each.

        Returns:
            (b, count, 3) float32.
        """
        return np.stack(list(self._pool.map(self._one, objects.tolist(), replicas.tolist())))

    def _one(self, index: int, replica: int) -> NDArray[np.float32]:
        samples = self._clouds.samples(index, replica)
        return self._input_spec.of_samples(samples, np.random.default_rng([index, replica]))


class AugmentedGrids:
    """Random variants of each object, as grids.

    Args:
        clouds: The variants.
        input_spec: Kind, shape and filling of the grids.
        replicas: Number of variants per object.
        cache: Cache of the grids.
        progress: Called with (done, all) while they are made.

    Raises:
        OutputError: The cache cannot be written.
    """

    def __init__(
        self,
        clouds: AugmentedClouds,
        input_spec: GridSpec,
        replicas: int,
        cache: GridCache,
        progress: Progress | None = None,
    ) -> None:
        self._replicas: list[PackedGrids] = []
        for replica in range(replicas):
            self._replicas.append(_cached(clouds, input_spec, replica, cache))
            if progress:
                progress(replica + 1, replicas)

    def batch(self, objects: NDArray[np.int64], replicas: NDArray[np.int64]) -> NDArray[np.uint8]:
        """The grids of some variants.

        Args:
            objects: (b,) indices into the set.
            replicas: (b,) the variant of each.

        Returns:
            (b, 1, *shape) uint8, 1 where occupied.
        """
        pairs = zip(objects, replicas, strict=True)
        return np.stack([self._replicas[replica][i : i + 1] for i, replica in pairs])


def _cached(
    clouds: AugmentedClouds, input_spec: GridSpec, replica: int, cache: GridCache
) -> PackedGrids:
    key = {
        "objects": clouds.objects.digest,
        "recipe": _filling(input_spec),  # The first version's name: cached grids stay valid.
        "augmentation": _changes(clouds.augmentation),
        "triangles": TRIANGLES,
        "seed": clouds.seed,
        "replica": replica,
    }
    if clouds.random_yaw:
        # Only if set, so that the keys of older grids stay the same.
        key["random_yaw"] = True
    return cache.get(key, len(clouds), input_spec.shape, lambda: _made(clouds, input_spec, replica))


def _filling(input_spec: GridSpec) -> dict[str, Any]:
    """All entries except the margin, which the augmentation's scale replaces for each grid."""
    settings = input_spec.to_dict()
    del settings["margin"], settings["dithered"]
    return settings


def _changes(augmentation: Augmentation) -> dict[str, Any]:
    """All settings except unused later ones, so that the keys of existing grids stay the same."""
    settings = asdict(augmentation)
    if not augmentation.damage:
        del settings["damage"]
    return settings


def _made(
    clouds: AugmentedClouds, input_spec: GridSpec, replica: int
) -> Iterator[NDArray[np.uint8]]:
    def of(chunk: NDArray[np.int64]) -> NDArray[np.uint8]:
        samples = [clouds.samples(int(i), replica) for i in chunk]
        return hits_batch([input_spec.unit_bounds] * len(samples), samples, threads=1)

    chunks = np.array_split(np.arange(len(clouds)), -(-len(clouds) // 64))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for grids in pool.map(of, chunks):
            yield from grids


class AugmentedClouds:
    """Random variants of each object, made on demand.

    Args:
        objects: The set.
        augmentation: The random changes.
        seed: Seed; a variant depends only on the seed, the object and the replica.
        filled: Whether samples are also drawn between the points.
        random_yaw: Whether every variant is rotated about the vertical by a random angle. The
            variants are otherwise the same as without it.
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
        # The angle is drawn last and only if used, so that the other draws stay the same.
        return _turned(samples, rng.uniform(0.0, 2 * np.pi)) if self.random_yaw else samples

    @cached_property
    def _surfaces(self) -> list[NDArray[np.int32]]:
        if not self._filled:
            return [np.empty((0, 3), np.int32)] * len(self.objects)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return list(pool.map(_surface, self.objects.points_xyz))


def _turned(samples_xyz: NDArray[np.float32], yaw: float) -> NDArray[np.float32]:
    """(m, 3) samples rotated by an angle [rad] about z, counter-clockwise seen from above."""
    return turned(samples_xyz.astype(np.float64), yaw).astype(np.float32)


def _surface(points_xyz: NDArray[np.float32]) -> NDArray[np.int32]:
    """(t, 3) triangles between near points, drawn by area."""
    try:
        mesh = short_edge_triangles(points_xyz)
        return mesh.faces[mesh.chosen_by_area(TRIANGLES)].astype(np.int32)
    except GeometryError:
        return np.empty((0, 3), np.int32)
