"""How a segmentation parts an object from its surroundings, with random errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.placed_object import PlacedObject
from circumspect.datasets.surroundings import CLUTTER, FURNITURE, NOTHING, OBJECT

if TYPE_CHECKING:
    from circumspect.datasets.scan_augmentation import ScanAugmentation

Chance = np.random.Generator
HIDDEN_BELOW = (0.1, 0.55)
"""Share of the object's height below which it is hidden, as of a chair at a table."""
MERGED_WITHIN = 0.3
"""Furniture taken for a part of the object reaches at most so far out of its box [m]."""
THINNED = (0.02, 0.6)
"""Share of the points that is left of a thinned scan, drawn log-uniformly."""
LEAK_STEP = 0.1
"""A segmentation leaks to a neighbouring pixel whose depth differs by less [m]."""


@dataclass(frozen=True)
class SegmentationErrors:
    """One segmentation's errors, the same in all views.

    Attributes:
        floor_cut: Below this height nothing is the object [m].
        leak_px: Width [px] of the border of neighbouring pixels that is added to the object.
        box: Lowest and highest corner [m] of a box whose whole content is taken; None for none.
        plane: Normal, and the share of the points on its near side, which are kept.
        merged: Corners [m] of a box within which other furniture is taken for the object.
        kept_share: Share of the points that are left.
        strays: Points beside the surface.
    """

    floor_cut: float
    leak_px: int
    box: tuple[NDArray[np.float64], NDArray[np.float64]] | None
    plane: tuple[NDArray[np.float64], float] | None
    merged: tuple[NDArray[np.float64], NDArray[np.float64]] | None
    kept_share: float
    strays: int

    @classmethod
    def drawn(
        cls, settings: ScanAugmentation, placed: PlacedObject, rng: Chance
    ) -> SegmentationErrors:
        """Draw the errors of one scan.

        Args:
            settings: Their chances.
            placed: The object.
            rng: Source of all chance.
        """
        floor_cut = float(rng.uniform(*settings.floor_cut))
        if rng.random() < settings.lowered:
            floor_cut = float(placed.high[2] * rng.uniform(*HIDDEN_BELOW))
        leak, box, plane, merged, kept_share, strays = 0, None, None, None, 1.0, 0
        if rng.random() < settings.leak:
            leak = int(rng.integers(1, 5))
        if rng.random() < settings.boxed:
            margin = rng.uniform(0.0, 0.12, 3)
            box = placed.low - margin, placed.high + margin
            floor_cut = min(floor_cut, float(rng.uniform(-0.03, 0.05)))
        if rng.random() < settings.cut:
            normal = rng.normal(size=3) * (1.0, 1.0, 0.5)
            plane = normal / np.linalg.norm(normal), float(rng.uniform(0.5, 0.95))
        if rng.random() < settings.merged:
            margin = rng.uniform(0.0, MERGED_WITHIN, 3)
            merged = placed.low - margin, placed.high + margin
        if rng.random() < settings.thinned:
            kept_share = float(np.exp(rng.uniform(*np.log(THINNED))))
        if rng.random() < settings.strays:
            strays = int(rng.integers(1, 25))
        return cls(floor_cut, leak, box, plane, merged, kept_share, strays)

    def mask(
        self, kind: NDArray[np.uint8], depth: NDArray[np.float32], points: NDArray[np.float32]
    ) -> NDArray[np.bool_]:
        """(h, w) which pixels are taken for the object."""
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
    """Which points lie in a box; an axis at a time, for NumPy reduces rows of three slowly."""
    inside = np.ones(points.shape[:-1], bool)
    for axis, (low, high) in enumerate(zip(*box, strict=True)):
        inside &= (points[..., axis] >= low) & (points[..., axis] <= high)
    return inside


def _grown(mask: NDArray[np.bool_], depth: NDArray[np.float32], by: int) -> NDArray[np.bool_]:
    """A mask with the pixels next to it at about the depth of their neighbour."""
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
