"""Whether coordinates can tell the shape that they lie on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError

FEWEST_STEPS = 64
"""Along the longest side of an object; the classifier's grid has as many cells across."""


def require_precision(points_xyz: NDArray[np.float64]) -> None:
    """Refuse an object so far from the origin that single precision rounds its shape away.

    Survey coordinates (easting, northing) in float32 are rounded to half a metre: a chair of them
    is a pillar or a plate, which would be named with confidence.

    Args:
        points_xyz: (n, 3), n >= 1; what is not finite is left to others.

    Raises:
        GeometryError: All coordinates are single precision, whose steps there are too coarse.
    """
    farthest = float(np.abs(points_xyz).max(initial=0.0))
    if not 0 < farthest < np.finfo(np.float32).max:
        return
    size = float(np.ptp(points_xyz, axis=0).max())
    step = float(np.spacing(np.float32(farthest)))
    if size == 0 or step * FEWEST_STEPS <= size:
        return
    if (points_xyz == points_xyz.astype(np.float32)).all():
        raise GeometryError(
            f"the object is {size:.3g} wide and {farthest:.3g} away from the origin, where single "
            f"precision has steps of {step:.3g}; subtract an offset in double precision, then save"
        )
