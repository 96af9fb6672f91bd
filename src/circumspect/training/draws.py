"""Which objects an epoch shows, in which order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def draw_epoch(
    labels: NDArray[np.int64], balance: float, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Draw as many objects as there are, each class by its share.

    Systematic resampling: an object expected k times comes floor(k) or ceil(k) times.

    Args:
        labels: (n,) class of each object.
        balance: 1 gives all classes the same share, 0 all objects the same chance.
        rng: Source of all chance.

    Returns:
        (n,) shuffled indices.
    """
    chances = (1.0 / np.bincount(labels)[labels]) ** balance
    steps = (np.arange(len(labels)) + rng.random()) / len(labels)
    drawn = np.searchsorted(np.cumsum(chances / chances.sum()), steps)
    return rng.permutation(drawn.clip(max=len(labels) - 1))


def learning_rate_at(step: int, steps: int, peak: float, warm_up: float) -> float:
    """A tenth of the peak, linearly up to it, then a cosine down to nearly nothing.

    Args:
        step: 0 … steps - 1.
        steps: Of the whole run.
        peak: The largest learning rate.
        warm_up: Share of the run until the peak.
    """
    rise = max(1.0, warm_up * steps)
    if step < rise:
        return peak * (0.1 + 0.9 * step / rise)
    decay = (step - rise) / max(1.0, steps - rise)
    return peak * (0.0005 + 0.9995 * 0.5 * (1.0 + np.cos(np.pi * decay)))
