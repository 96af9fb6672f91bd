"""Sizes in metres for objects of sets whose unit is unknown."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

INCH = 0.0254
"""Most of ModelNet10's models are in inches [m]."""
SIZES: Mapping[str, tuple[tuple[float, float], tuple[float, float]]] = MappingProxyType(
    {
        "bathtub": ((0.40, 1.10), (1.20, 2.00)),
        "bed": ((0.40, 1.80), (1.70, 2.50)),
        "chair": ((0.60, 1.25), (0.40, 1.00)),
        "desk": ((0.65, 1.60), (0.80, 2.40)),
        "dresser": ((0.60, 1.50), (0.50, 1.90)),
        "monitor": ((0.25, 0.80), (0.30, 1.30)),
        "night_stand": ((0.40, 0.85), (0.35, 0.90)),
        "sofa": ((0.55, 1.10), (1.20, 3.40)),
        "table": ((0.30, 1.10), (0.45, 3.00)),
        "toilet": ((0.35, 1.00), (0.40, 0.90)),
    }
)
"""Class to the ranges of height and of the longest horizontal side [m] of furniture as it is sold,
a little wider than the sizes in the Sweet Home 3D catalogues."""


def metres_per_unit(
    label: str, extent_xyz: NDArray[np.floating], rng: np.random.Generator
) -> float:
    """Choose a size for an object of unknown unit.

    Inches are kept where they make a size that furniture of the class has. Otherwise a scale is
    drawn, log-uniformly, among those that do.

    Args:
        label: Its class; one of `SIZES`.
        extent_xyz: (3,) its sides in the unit of its file, z up.
        rng: Draws the scale.

    Returns:
        Metres in one unit.
    """
    heights, sides = SIZES[label]
    height, side = float(extent_xyz[2]), float(max(extent_xyz[:2]))
    least = max(heights[0] / height, sides[0] / side)
    most = min(heights[1] / height, sides[1] / side)
    if least <= INCH <= most:
        return INCH
    if least > most:  # Odd proportions: as near to both ranges as can be.
        return float(np.sqrt(least * most))
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def size_factors(label: str, extent_xyz: NDArray[np.floating]) -> tuple[float, float]:
    """By how much an object may shrink and grow and still have a size of its class.

    Args:
        label: Its class; one of `SIZES`.
        extent_xyz: (3,) its sides [m], z up.

    Returns:
        The smallest factor, at most 1, and the largest, at least 1.
    """
    heights, sides = SIZES[label]
    height, side = float(extent_xyz[2]), float(max(extent_xyz[:2]))
    least = max(heights[0] / height, sides[0] / side)
    most = min(heights[1] / height, sides[1] / side)
    return min(least, 1.0), max(most, 1.0)
