"""Points that a scanner wrote in the place of ones it did not measure."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import NDArray

_LOG = logging.getLogger(__name__)

MIN_ORIGIN_SHARE = 0.01
"""So many exact copies of the origin are no surface: in an organised cloud they mark holes."""
MIN_ORIGIN_COUNT = 16


def missing_points(points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points are NaN or infinite, or one of many that lie exactly at the origin.

    Sensors that can not write NaN put what they did not measure at (0, 0, 0). A warning in the log
    counts both kinds.

    Args:
        points_xyz: (n, 3).

    Returns:
        (n,) True for a missing point; never all because of the origin.
    """
    missing = ~np.logical_and.reduce(np.isfinite(points_xyz), axis=1)
    if count := int(missing.sum()):
        _LOG.warning("ignored %d of %d points that are NaN or infinite", count, len(missing))
    origin = np.logical_and.reduce(points_xyz == 0, axis=1)
    count = int(origin.sum())
    enough = max(MIN_ORIGIN_COUNT, MIN_ORIGIN_SHARE * len(origin))
    if not enough <= count < len(origin) - int(missing.sum()):
        return missing
    _LOG.warning("ignored %d of %d points at (0, 0, 0): no measurement", count, len(origin))
    return np.logical_or(missing, origin)
