"""Draws of training objects in an epoch, and the learning rate schedule."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

MIN_DRAWS = 500
"""Minimum number of draws in an epoch; with fewer a network would learn too little."""


def passes_for(count: int) -> int:
    """Number of passes through a set per epoch that draws at least `MIN_DRAWS` objects.

    Args:
        count: Number of objects in the set.
    """
    return math.ceil(MIN_DRAWS / max(1, count))


def class_chances(labels: NDArray[np.int64], balance: float) -> NDArray[np.float64]:
    """Probability of drawing each object.

    Args:
        labels: (n,) class of each object.
        balance: 1 gives all classes the same probability, 0 all objects.

    Returns:
        (n,) probabilities that sum to 1.
    """
    chances = (1.0 / np.bincount(labels)[labels]) ** balance
    return chances / chances.sum()


def draw_epoch(
    chances: NDArray[np.float64], count: int, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Draw objects by systematic resampling.

    An object with k expected draws is drawn floor(k) or ceil(k) times.

    Args:
        chances: (n,) probabilities that sum to 1.
        count: Number of draws.
        rng: Random generator.

    Returns:
        (count,) shuffled indices.
    """
    steps = (np.arange(count) + rng.random()) / count
    drawn = np.searchsorted(np.cumsum(chances), steps)
    return rng.permutation(drawn.clip(max=len(chances) - 1))


def learning_rate_at(step: int, steps: int, peak: float, warm_up: float) -> float:
    """Learning rate: linear warm-up from a tenth of the peak, then cosine decay to nearly 0.

    Args:
        step: 0 … steps - 1.
        steps: Number of steps of the whole run.
        peak: Maximum learning rate.
        warm_up: Fraction of the run until the peak.
    """
    rise = max(1.0, warm_up * steps)
    if step < rise:
        return peak * (0.1 + 0.9 * step / rise)
    decay = (step - rise) / max(1.0, steps - rise)
    return peak * (0.0005 + 0.9995 * 0.5 * (1.0 + np.cos(np.pi * decay)))
