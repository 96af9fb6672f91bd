"""Whether a cloud can be one object at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.floor_left import holds_floor

FEWEST_POINTS = 128
"""Distinct points below which a classifier with an open set never reports `in_distribution`.
Measured by `benchmarks.few_points`: three points are near to some training object, too."""


def is_one_object(points: NDArray[np.float64]) -> bool:
    """Whether a cloud has enough distinct points and no floor beneath.

    Args:
        points: (n, 3).
    """
    return _are_distinct(points, FEWEST_POINTS) and not holds_floor(points)


def _are_distinct(points: NDArray[np.float64], fewest: int) -> bool:
    """Whether so many of them lie in different places."""
    # The first points of a large cloud are enough, unless they are repeated.
    return any(len(np.unique(part, axis=0)) >= fewest for part in (points[: 8 * fewest], points))
