"""Whether a cloud still holds the floor that its object stood on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LAYER = 0.04
"""The floor is looked for in this share of the height, from the lowest hundredth of the points."""
FEWEST_SHARE = 0.05
"""A floor has at least this share of the points …"""
BEYOND = 1.1
"""… and reaches so many times as far out as what stands on it."""
LOOKED_AT = 10_000
"""So many points tell."""


def holds_floor(points_xyz: NDArray[np.floating]) -> bool:
    """Whether the lowest layer reaches beyond all that is above it.

    Of ModelNet10's training objects hardly any does: a test counts them. Floors that are thicker
    than the layer, by noise or because they lean, are not found.

    Args:
        points_xyz: (n, 3) [m], z up.
    """
    points = points_xyz[:: max(1, len(points_xyz) // LOOKED_AT)]
    heights = points[:, 2]
    low = heights < np.quantile(heights, 0.01) + LAYER * np.ptp(heights)
    if low.mean() < FEWEST_SHARE or (~low).sum() < FEWEST_SHARE * len(points):
        return False
    above = points[~low, :2]
    centre = (above.min(axis=0) + above.max(axis=0)) / 2
    reach = np.quantile(np.hypot(*(above - centre).T), 0.98)
    return bool(np.quantile(np.hypot(*(points[low, :2] - centre).T), 0.9) > BEYOND * reach)
