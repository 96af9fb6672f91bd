"""Simulated segmentation of an object with random errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.surroundings import CLUTTER, FURNITURE, NOTHING, OBJECT

Chance = np.random.Generator
LEAK_STEP = 0.1
"""A segmentation leaks to a neighbouring pixel whose depth differs by less [m]."""


@dataclass(frozen=True)
class SegmentationErrors:
    """The errors of one segmentation, the same in all views.

    Attributes:
        floor_cut: The object is cut off below this height [m].
        leak_px: Width [px] of the border of neighbouring pixels that is added to the object.
        box: Lowest and highest corner [m] of a box whose whole content is segmented; None for none.
        plane: Normal of a plane, and the fraction of the points on its near side, which are kept.
        merged: Corners [m] of a box in which other furniture is segmented with the object.
        kept_share: Fraction of the points that remain.
        strays: Number of stray points.
    """

    floor_cut: float
    leak_px: int
    box: tuple[NDArray[np.float64], NDArray[np.float64]] | None
    plane: tuple[NDArray[np.float64], float] | None
    merged: tuple[NDArray[np.float64], NDArray[np.float64]] | None
    kept_share: float
    strays: int

    def mask(
        self, kind: NDArray[np.uint8], depth: NDArray[np.float32], points: NDArray[np.float32]
    ) -> NDArray[np.bool_]:
        """(h, w) mask of the object's pixels."""
        mask = (kind == OBJECT) | (kind == CLUTTER)
        if self.merged is not None:
            mask |= (kind == FURNITURE) & _within(points, self.merged)
        if self.box is not None:
            mask = (kind != NOTHING) & _within(points, self.box)
        elif self.leak_px:
            mask = _grown(mask, depth, self.leak_px)
        return mask & np.isfinite(depth) & (points[..., 2] > self.floor_cut)

    def finished(self, points: NDArray[np.floating], rng: Chance) -> NDArray[np.floating]:
        """The fused points after a cut, with strays."""
        if self.plane is not None:
            along = points @ self.plane[0]
            points = points[along <= np.quantile(along, self.plane[1])]
        if self.kept_share < 1.0:
            kept = rng.random(len(points)) < self.kept_share
            points = points[kept] if kept.any() else points[:1]
        if self.strays:
            low, high = points.min(axis=0), points.max(axis=0)
            spread = rng.uniform(low - 0.05, high + 0.05, (self.strays, 3))
            points = np.concatenate([points, spread])
        return points


def _within(
    points: NDArray[np.float32], box: tuple[NDArray[np.float64], NDArray[np.float64]]
) -> NDArray[np.bool_]:
    """Mask of points in a box; axis by axis, since NumPy reduces rows of three slowly."""
    inside = np.ones(points.shape[:-1], bool)
    for axis, (low, high) in enumerate(zip(*box, strict=True)):
        inside &= (points[..., axis] >= low) & (points[..., axis] <= high)
    return inside


def _grown(mask: NDArray[np.bool_], depth: NDArray[np.float32], by: int) -> NDArray[np.bool_]:
    """A mask extended by neighbouring pixels of similar depth."""
    rows, columns = depth.shape
    padded = np.pad(depth, 1, constant_values=np.nan)
    grown = np.pad(mask, 1)
    with np.errstate(invalid="ignore"):
        for _ in range(by):
            more = grown[1:-1, 1:-1].copy()
            for down, right in ((0, 1), (2, 1), (1, 0), (1, 2)):
                beside = slice(down, down + rows), slice(right, right + columns)
                more |= grown[beside] & (np.abs(padded[beside] - depth) < LEAK_STEP)
            grown[1:-1, 1:-1] = more
    return grown[1:-1, 1:-1]
