"""Depth as cameras and files have it: whole millimetres (16UC1, REP 118)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

NO_DEPTH = (0, 65535)
"""What stands for no depth; 0 is written."""


def metres(millimetres: NDArray[np.unsignedinteger]) -> NDArray[np.float32]:
    """Depth in metres.

    Args:
        millimetres: Any shape; 0 and 65535 are invalid.

    Returns:
        float32 [m], the same shape, NaN where invalid.
    """
    depth = millimetres.astype(np.float32) * np.float32(1e-3)
    depth[(millimetres == NO_DEPTH[0]) | (millimetres == NO_DEPTH[1])] = np.nan
    return depth


def millimetres(depth: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Depth in whole millimetres; `metres` of it is the nearest depth that 16UC1 can hold.

    Args:
        depth: Any shape [m]; NaN, and what is outside of 0.5 mm to 65.534 m, becomes 0.

    Returns:
        uint16 [mm], the same shape.
    """
    rounded = np.rint(depth * np.float32(1e3))
    with np.errstate(invalid="ignore"):
        held = (rounded >= 1) & (rounded < NO_DEPTH[1])
    return np.where(held, rounded, 0).astype(np.uint16)
