"""A set of few objects, quickly made."""

import numpy as np

from circumspect.datasets import ObjectSet


def small_set(count=6, points=20, seed=0):
    rng = np.random.default_rng(seed)
    names = np.array([f"bed_{i:04d}" for i in range(count)])
    return ObjectSet(
        rng.random((count, points, 3)).astype(np.float32),
        np.arange(count, dtype=np.int64) % 2,
        names,
        ("bed", "chair"),
    )
