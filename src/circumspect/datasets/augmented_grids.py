"""Augmented grids of a set: several per object, made once and cached."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridRecipe
from circumspect.datasets.augmentation import Augmentation
from circumspect.datasets.augmented_clouds import TRIANGLES, AugmentedClouds
from circumspect.datasets.grid_cache import GridCache, PackedGrids
from circumspect.grid import hits_batch

Progress = Callable[[int, int], None]


class AugmentedGrids:
    """Random variants of each object, as grids.

    Args:
        clouds: The variants.
        recipe: Kind and shape of the grids, and how surfaces are filled.
        replicas: Variants an object.
        cache: Where the grids are kept.
        progress: Called with (done, all) while they are made.

    Raises:
        OutputError: The cache can not be written.
    """

    def __init__(
        self,
        clouds: AugmentedClouds,
        recipe: GridRecipe,
        replicas: int,
        cache: GridCache,
        progress: Progress | None = None,
    ) -> None:
        self._replicas: list[PackedGrids] = []
        for replica in range(replicas):
            self._replicas.append(_cached(clouds, recipe, replica, cache))
            if progress:
                progress(replica + 1, replicas)

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


def _cached(
    clouds: AugmentedClouds, recipe: GridRecipe, replica: int, cache: GridCache
) -> PackedGrids:
    key = {
        "objects": clouds.objects.digest,
        "recipe": _filling(recipe),
        "augmentation": _changes(clouds.augmentation),
        "triangles": TRIANGLES,
        "seed": clouds.seed,
        "replica": replica,
    }
    if clouds.random_yaw:
        # Only then: grids that were made before there was this setting keep their names.
        key["random_yaw"] = True
    return cache.get(key, len(clouds), recipe.shape, lambda: _made(clouds, recipe, replica))


def _filling(recipe: GridRecipe) -> dict[str, Any]:
    """All but the margin: the augmentation's scale has the sizes of the grids, one of each."""
    settings = recipe.to_dict()
    del settings["margin"], settings["staggered"]
    return settings


def _changes(augmentation: Augmentation) -> dict[str, Any]:
    """All of its settings, but those that came later and are not used: grids stay the same."""
    settings = asdict(augmentation)
    if not augmentation.damage:
        del settings["damage"]
    return settings


def _made(clouds: AugmentedClouds, recipe: GridRecipe, replica: int) -> Iterator[NDArray[np.uint8]]:
    def of(chunk: NDArray[np.int64]) -> NDArray[np.uint8]:
        samples = [clouds.samples(int(i), replica) for i in chunk]
        return hits_batch([recipe.unit_bounds] * len(samples), samples, threads=1)

    chunks = np.array_split(np.arange(len(clouds)), -(-len(clouds) // 64))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for grids in pool.map(of, chunks):
            yield from grids
