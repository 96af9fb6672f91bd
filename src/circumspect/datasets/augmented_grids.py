"""Augmented grids of a set: several per object, made once and cached."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridRecipe
from circumspect.datasets.augmentation import Augmentation
from circumspect.datasets.grid_cache import GridCache, PackedGrids
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import GeometryError
from circumspect.geometry import short_edge_triangles
from circumspect.grid import hits_batch

TRIANGLES = 10_000
"""Samples drawn on the surface of each variant."""
Progress = Callable[[int, int], None]


class AugmentedGrids:
    """Random variants of each object, as grids.

    Args:
        objects: The set.
        recipe: Kind and shape of the grids, and how surfaces are filled.
        augmentation: The random changes.
        replicas: Variants an object.
        seed: Of all chance; a variant depends on it, the object and the replica alone.
        cache: Where the grids are kept.
        progress: Called with (done, all) while they are made.

    Raises:
        OutputError: The cache can not be written.
    """

    def __init__(
        self,
        objects: ObjectSet,
        recipe: GridRecipe,
        augmentation: Augmentation,
        replicas: int,
        seed: int,
        cache: GridCache,
        progress: Progress | None = None,
    ) -> None:
        self._objects, self._recipe, self._augmentation = objects, recipe, augmentation
        self._seed = seed
        self._surfaces: list[NDArray[np.int32]] | None = None
        self._replicas: list[PackedGrids] = []
        for replica in range(replicas):
            self._replicas.append(self._cached(replica, cache))
            if progress:
                progress(replica + 1, replicas)
        self._surfaces = None

    def batch(self, objects: NDArray[np.int64], replicas: NDArray[np.int64]) -> NDArray[np.uint8]:
        """Grids of chosen objects.

        Args:
            objects: (b,) indices into the set.
            replicas: (b,) the variant of each.

        Returns:
            (b, 1, *shape) uint8, 1 where occupied.
        """
        pairs = zip(objects, replicas, strict=True)
        return np.stack([self._replicas[replica][i : i + 1] for i, replica in pairs])

    def __len__(self) -> int:
        return len(self._replicas)

    def _cached(self, replica: int, cache: GridCache) -> PackedGrids:
        key = {
            "objects": self._objects.digest,
            "recipe": self._recipe.to_dict(),
            "augmentation": asdict(self._augmentation),
            "triangles": TRIANGLES,
            "seed": self._seed,
            "replica": replica,
        }
        shape = self._recipe.shape
        return cache.get(key, len(self._objects), shape, lambda: self._made(replica))

    def _made(self, replica: int) -> Iterator[NDArray[np.uint8]]:
        if self._surfaces is None:
            self._surfaces = _surfaces(self._objects)
        chunks = np.array_split(np.arange(len(self._objects)), -(-len(self._objects) // 64))
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for grids in pool.map(lambda chunk: self._made_chunk(chunk, replica), chunks):
                yield from grids

    def _made_chunk(self, chunk: NDArray[np.int64], replica: int) -> NDArray[np.uint8]:
        surfaces = self._surfaces or []
        clouds = [
            self._augmentation.apply(
                self._objects.points_xyz[i],
                surfaces[i],
                np.random.default_rng([self._seed, replica, int(i)]),
            )
            for i in chunk
        ]
        return hits_batch([self._recipe.unit_bounds] * len(clouds), clouds, threads=1)


def _surfaces(objects: ObjectSet) -> list[NDArray[np.int32]]:
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(_surface, objects.points_xyz))


def _surface(points_xyz: NDArray[np.float32]) -> NDArray[np.int32]:
    """(t, 3) triangles between near points, chosen by area."""
    try:
        mesh = short_edge_triangles(points_xyz)
        return mesh.faces[mesh.chosen_by_area(TRIANGLES)].astype(np.int32)
    except GeometryError:
        return np.empty((0, 3), np.int32)
