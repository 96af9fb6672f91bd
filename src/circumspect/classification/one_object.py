"""Whether a cloud can be one object at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.floor_left import holds_floor

FEWEST_POINTS = 128
"""A cloud of fewer distinct ones is never in distribution to a classifier that has an open set:
three points are near enough to some training object, too; measured by `benchmarks.few_points`."""


def is_one_object(points: NDArray[np.float64]) -> bool:
    """Whether there is enough of it, and no floor beneath.

    Args:
        points: (n, 3).
    """
    return _are_distinct(points, FEWEST_POINTS) and not holds_floor(points)


def _are_distinct(points: NDArray[np.float64], fewest: int) -> bool:
    """Whether so many of them lie in different places."""
    # Of large clouds the first points tell, unless they are repeated.
    return any(len(np.unique(part, axis=0)) >= fewest for part in (points[: 8 * fewest], points))
