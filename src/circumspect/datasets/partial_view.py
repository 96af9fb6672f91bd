"""What of a surface a camera sees that goes part of the way round it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PIXELS = 32
"""Side of the depth images that decide what hides what [px]."""
THICKNESS = 0.05
"""Points this far behind the nearest one of their pixel are hidden, in units of the scale."""


@dataclass(frozen=True)
class PartialView:
    """A camera that looks at the origin from far away while it goes along an arc.

    Attributes:
        start: Heading of the first look [rad], counter-clockwise from +x.
        arc: Way round [rad]; 2π and more is all the way.
        elevation: Angle above the horizon from which it looks down [rad].
        looks: How many looks on the way.
    """

    start: float
    arc: float
    elevation: float
    looks: int = 8

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> PartialView:
        """A scan at a random stage: from a quarter to the whole way round, one look every 45°."""
        arc = float(rng.uniform(np.pi / 2, 2.5 * np.pi))
        elevation = float(rng.uniform(np.radians(8), np.radians(45)))
        looks = max(2, int(np.ceil(min(arc, 2 * np.pi) / (np.pi / 4))))
        return cls(float(rng.uniform(0, 2 * np.pi)), arc, elevation, looks)

    def sees(self, points_xyz: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Which points are seen in any of the looks.

        Depth images of `PIXELS` x `PIXELS` by parallel projection: enough at the resolution of
        a grid, and it needs neither triangles nor a ray caster.

        Args:
            points_xyz: (n, 3) dense samples of the surface, in units of the object's scale.

        Returns:
            (n,) bool.
        """
        whole = self.arc >= 2 * np.pi
        arc = 2 * np.pi if whole else self.arc
        steps = np.arange(self.looks) / (self.looks if whole else max(self.looks - 1, 1))
        seen = np.zeros(len(points_xyz), bool)
        for heading in self.start + arc * steps:
            seen |= _nearest(points_xyz, float(heading), self.elevation)
        return seen


def _nearest(
    points_xyz: NDArray[np.floating], heading: float, elevation: float
) -> NDArray[np.bool_]:
    """(n,) the points that nothing hides from one direction."""
    level, rise = np.cos(elevation), np.sin(elevation)
    towards = np.array([level * np.cos(heading), level * np.sin(heading), rise])
    across = np.array([-np.sin(heading), np.cos(heading), 0.0])
    axes = np.column_stack([across, np.cross(towards, across), towards])
    u, v, depth = (points_xyz @ axes.astype(points_xyz.dtype)).T
    u, v = u - u.min(), v - v.min()
    side = max(float(u.max()), float(v.max()), 1e-9) / (PIXELS - 1)
    # One more pixel on every side, so that each has four neighbours.
    width = PIXELS + 2
    pixel = ((u / side).astype(np.intp) + 1) * width + (v / side).astype(np.intp) + 1
    front = np.full(width * width, -np.inf, depth.dtype)
    np.maximum.at(front, pixel, depth)
    image = front.reshape(width, width)
    # A pixel without a sample of its own is a gap between samples, not a hole, where three of its
    # four neighbours have one.
    around = [image[:-2, 1:-1], image[2:, 1:-1], image[1:-1, :-2], image[1:-1, 2:]]
    image[1:-1, 1:-1] = np.maximum(image[1:-1, 1:-1], np.sort(around, axis=0)[1])
    return depth >= front[pixel] - THICKNESS
