"""Whether an object that is said to be in metres is as large as things in a room are."""

from __future__ import annotations

import numpy as np

from circumspect.errors import InputError
from circumspect.geometry import PointCloud

SMALLEST, LARGEST = 0.02, 10.0
"""Longest side of what a robot may stand before [m]."""


def require_plausible_size(cloud: PointCloud) -> None:
    """Refuse sizes that come from a wrong unit.

    Raises:
        InputError: The object is smaller or larger than anything in a room.
    """
    longest = float(max(map(np.ptp, cloud.points_xyz.T)))
    if SMALLEST <= longest <= LARGEST:
        return
    digits = ".0f" if longest >= 100.0 else ".3g"
    shown = f"{1e3 * longest:.3g} mm" if longest < 1.0 else f"{longest:{digits}} m"
    raise InputError(
        f"the object would be {shown} long, and {100 * SMALLEST:.0f} cm to {LARGEST:.0f} m are "
        "plausible; check the unit of its points: m, cm, mm or in"
    )
