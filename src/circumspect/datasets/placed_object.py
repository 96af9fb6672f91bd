"""A training object where it stands, and boxes placed by it."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.surroundings import CLUTTER, Box

Chance = np.random.Generator


@dataclass(frozen=True)
class PlacedObject:
    """The box round an object, its axes those of the map.

    Attributes:
        low: (3,) [m] smallest coordinates.
        high: (3,) [m] largest.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def middle(self) -> NDArray[np.float64]:
        """(3,) [m] of the box."""
        return (self.low + self.high) / 2

    @property
    def half(self) -> NDArray[np.float64]:
        """(3,) [m] half of its edges."""
        return (self.high - self.low) / 2

    @property
    def radius(self) -> float:
        """Of the sphere round the box."""
        return float(np.linalg.norm(self.half))

    @property
    def reach(self) -> float:
        """From the middle to the farthest corner, in the plane."""
        return float(np.hypot(*self.half[:2]))

    def along(self, direction_xy: NDArray[np.float64]) -> float:
        """From the middle to the box's border in a direction."""
        return float(np.abs(direction_xy * self.half[:2]).sum())

    def occluder(self, bearing: float, rng: Chance) -> Box:
        """A box or a table top between the camera and the object."""
        heading = bearing + rng.normal(0, 0.35)
        direction = np.array([np.cos(heading), np.sin(heading)])
        half = rng.uniform(0.1, 0.5, 3)
        away = self.along(direction) + half[:2].max() * 1.2 + rng.uniform(0.0, 0.5)
        if rng.random() < 0.4:  # A table top; it may reach over the object.
            half[2], middle_z = 0.02, rng.uniform(0.45, 0.8)
            away *= rng.uniform(0.3, 1.0)
            half[:2] += 0.2
        else:
            half[2] = rng.uniform(0.15, 0.6)
            middle_z = half[2]
        centre = np.append(self.middle[:2] + away * direction, middle_z)
        return Box(centre, half, float(rng.uniform(0, pi)))

    def neighbour(self, rng: Chance) -> Box:
        """A box that stands beside the object."""
        heading = rng.uniform(0, 2 * pi)
        direction = np.array([np.cos(heading), np.sin(heading)])
        half = self.half * rng.uniform(0.3, 1.0, 3)
        away = self.along(direction) + np.abs(direction * half[:2]).sum() + rng.uniform(0.0, 0.2)
        return Box(np.append(self.middle[:2] + away * direction, half[2]), half, 0.0)

    def clutter(self, rng: Chance) -> Box:
        """Something on the object, or a sheet that stands against it."""
        if rng.random() < 0.6:
            half = np.minimum(rng.uniform(0.03, 0.2, 3), 0.5 * self.half)
            x, y = self.middle[:2] + rng.uniform(-0.9, 0.9, 2) * self.half[:2]
            bottom = self.high[2] * (1.0 if rng.random() < 0.5 else rng.uniform(0.3, 1.0))
            centre = np.array([x, y, bottom + half[2]])
            return Box(centre, half, float(rng.uniform(0, pi)), CLUTTER)
        heading = rng.uniform(0, 2 * pi)
        direction = np.array([np.cos(heading), np.sin(heading)])
        half = np.array([rng.uniform(0.01, 0.08), *rng.uniform(0.1, 0.7, 2) * self.half[1:]])
        away = self.along(direction) + half[0] + rng.uniform(-0.05, 0.1)
        z = max(half[2], float(rng.uniform(0.2, 1.0) * self.high[2]))
        # The thin side towards the object.
        return Box(np.append(self.middle[:2] + away * direction, z), half, heading, CLUTTER)
