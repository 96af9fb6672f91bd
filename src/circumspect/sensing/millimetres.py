"""Conversion of depth between metres and whole millimetres (16UC1, REP 118)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

NO_DEPTH = (0, 65535)
"""Values of missing depth; 0 is written."""


def metres(millimetres: NDArray[np.unsignedinteger]) -> NDArray[np.float32]:
    """Convert to metres.

    Args:
        millimetres: Any shape; 0 and 65535 are invalid.

    Returns:
        float32 [m], the same shape, NaN where invalid.
    """
    depth = millimetres.astype(np.float32) * np.float32(1e-3)
    depth[(millimetres == NO_DEPTH[0]) | (millimetres == NO_DEPTH[1])] = np.nan
    return depth


def millimetres(depth: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Convert to whole millimetres, rounded; inverse of `metres`.

    Args:
        depth: Any shape [m]; NaN and values outside 0.5 mm to 65.534 m become 0.

    Returns:
        uint16 [mm], the same shape.
    """
    rounded = np.rint(depth * np.float32(1e3))
    with np.errstate(invalid="ignore"):
        held = (rounded >= 1) & (rounded < NO_DEPTH[1])
    return np.where(held, rounded, 0).astype(np.uint16)
