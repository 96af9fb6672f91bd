"""Procedural furniture as a labelled set."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.cache_folder import cache_folder
from circumspect.datasets.farthest_points import evenly_sampled
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.point_pack import read_point_pack, write_point_pack
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES, make_furniture

VERSION = 1


def furniture_set(
    each: int, progress: Callable[[int, int], None] | None = None, first_seed: int = 1_000_000
) -> ObjectSet:
    """Create equally many objects of each of the ten categories; the result is cached.

    Args:
        each: Number of objects per category.
        progress: Called with (done, all).
        first_seed: First of the consecutive seeds; the seeds of the demo are lower.

    Raises:
        OutputError: The cache cannot be written.
    """
    cached = cache_folder("packs") / f"furniture-{VERSION}-{each}-{first_seed}.npz"
    with suppress(InputError):
        return read_point_pack(cached)
    jobs = [(category, first_seed + i) for category in CATEGORIES for i in range(each)]

    def made(job: tuple[str, int]) -> NDArray[np.float32]:
        return evenly_sampled(make_furniture(*job), job[1])

    points = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for cloud in pool.map(made, jobs):
            points.append(cloud)
            if progress:
                progress(len(points), len(jobs))
    objects = ObjectSet(
        np.stack(points),
        np.repeat(np.arange(len(CATEGORIES)), each),
        np.array([f"procedural_{category}_{seed}" for category, seed in jobs]),
        CATEGORIES,
    )
    write_point_pack(cached, objects)
    return read_point_pack(cached)
