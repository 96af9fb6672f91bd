"""Which objects an epoch shows, in which order, and how fast it learns from them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

FEWEST_DRAWS = 500
"""A network that saw less in each of its epochs would have learnt little at the end."""


def passes_for(count: int) -> int:
    """How often an epoch is to go through a set, so that it shows about `FEWEST_DRAWS` objects.

    Args:
        count: Objects in the set.
    """
    return math.ceil(FEWEST_DRAWS / max(1, count))


def class_chances(labels: NDArray[np.int64], balance: float) -> NDArray[np.float64]:
    """How often to draw each object.

    Args:
        labels: (n,) class of each object.
        balance: 1 gives all classes the same share, 0 all objects the same chance.

    Returns:
        (n,) chances that sum to 1.
    """
    chances = (1.0 / np.bincount(labels)[labels]) ** balance
    return chances / chances.sum()


def draw_epoch(
    chances: NDArray[np.float64], count: int, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Draw objects by systematic resampling.

    An object expected k times comes floor(k) or ceil(k) times.

    Args:
        chances: (n,) that sum to 1.
        count: How many to draw.
        rng: Source of all chance.

    Returns:
        (count,) shuffled indices.
    """
    steps = (np.arange(count) + rng.random()) / count
    drawn = np.searchsorted(np.cumsum(chances), steps)
    return rng.permutation(drawn.clip(max=len(chances) - 1))


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
