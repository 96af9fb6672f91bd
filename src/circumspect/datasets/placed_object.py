"""Placement of boxes and furniture relative to a training object in a scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.surroundings import CLUTTER, FURNITURE, NOTHING, Hits, RoomBox
from circumspect.furniture import CATEGORIES, make_furniture

Chance = np.random.Generator
FIRST_SEED = 2_000_000
"""First seed of the furniture; the seeds for training, validation and benchmarks are lower."""
EACH = 8
"""Number of pieces of each category."""
GAPS = (-0.7, 0.3)
"""Distance between the boxes of object and furniture, in half depths of the furniture; below 0 they
overlap, like a table and its chair."""


@dataclass(frozen=True)
class Neighbour:
    """Furniture on the floor, rotated about the vertical.

    Attributes:
        caster: Ray caster of its surface, about the z axis.
        middle_xy: (2,) [m] position.
        yaw: Rotation [rad].
    """

    caster: ObjectCaster
    middle_xy: NDArray[np.float64]
    yaw: float

    @classmethod
    def drawn(
        cls,
        low_xyz: NDArray[np.float64],
        high_xyz: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Neighbour:
        """Place random furniture next to an object.

        Args:
            low_xyz: (3,) [m] smallest coordinates of the object.
            high_xyz: (3,) [m] largest coordinates of the object.
            rng: Random generator.
        """
        category = str(rng.choice(list(CATEGORIES)))
        caster = _piece(category, int(rng.integers(EACH)))
        bearing, yaw = rng.uniform(0, 2 * pi, 2)
        direction = np.array([cos(bearing), sin(bearing)])
        half_xy = np.ptp(caster.corners_xyz, axis=0)[:2] / 2
        # Half of its extent along the direction, in its own frame.
        own = _turned(direction, -yaw)
        depth = float(np.abs(own * half_xy).sum())
        away = float(np.abs(direction * (high_xyz - low_xyz)[:2] / 2).sum())
        away += depth * (1 + rng.uniform(*GAPS))
        middle = (low_xyz + high_xyz)[:2] / 2
        return cls(caster, middle + away * direction, float(yaw))

    def is_clear_of(self, position_xyz: NDArray[np.float64]) -> bool:
        """Whether a camera is clearly outside the furniture."""
        away = float(np.hypot(*(position_xyz[:2] - self.middle_xy)))
        return away > float(np.hypot(*self.caster.corners_xyz[1, :2])) + 0.1

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """First hits of rays, see `RoomSurroundings.hits`."""
        origin = np.append(_turned(origin_xyz[:2] - self.middle_xy, -self.yaw), origin_xyz[2])
        rays = np.column_stack([_turned(rays_xyz[:, :2], -self.yaw), rays_xyz[:, 2]])
        found = self.caster.hits(origin, rays.astype(np.float32), np.ones(3))
        kind = np.where(found.kind == NOTHING, NOTHING, FURNITURE).astype(np.uint8)
        return replace(found, kind=kind)


@cache
def _piece(category: str, number: int) -> ObjectCaster:
    return ObjectCaster(make_furniture(category, FIRST_SEED + number))


def _turned(xy: NDArray[np.floating], yaw: float) -> NDArray[np.float64]:
    """(…, 2) points rotated about the vertical."""
    return xy.astype(np.float64) @ np.array([[cos(yaw), sin(yaw)], [-sin(yaw), cos(yaw)]])


@dataclass(frozen=True)
class PlacedObject:
    """The axis-aligned box of an object, map frame.

    Attributes:
        low: (3,) [m] smallest coordinates.
        high: (3,) [m] largest.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def middle(self) -> NDArray[np.float64]:
        """(3,) [m] centre of the box."""
        return (self.low + self.high) / 2

    @property
    def half(self) -> NDArray[np.float64]:
        """(3,) [m] half of its edges."""
        return (self.high - self.low) / 2

    @property
    def radius(self) -> float:
        """Radius of the bounding sphere [m]."""
        return float(np.linalg.norm(self.half))

    @property
    def reach(self) -> float:
        """Horizontal distance from the centre to the farthest corner [m]."""
        return float(np.hypot(*self.half[:2]))

    def along(self, direction_xy: NDArray[np.float64]) -> float:
        """Distance from the centre to the box's border in a direction [m]."""
        return float(np.abs(direction_xy * self.half[:2]).sum())

    def occluder(self, bearing: float, rng: Chance) -> RoomBox:
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
        return RoomBox(centre, half, float(rng.uniform(0, pi)))

    def neighbour(self, rng: Chance) -> RoomBox:
        """A box beside the object."""
        heading = rng.uniform(0, 2 * pi)
        direction = np.array([np.cos(heading), np.sin(heading)])
        half = self.half * rng.uniform(0.3, 1.0, 3)
        away = self.along(direction) + np.abs(direction * half[:2]).sum() + rng.uniform(0.0, 0.2)
        return RoomBox(np.append(self.middle[:2] + away * direction, half[2]), half, 0.0)

    def clutter(self, rng: Chance) -> RoomBox:
        """A box on the object, or a sheet that leans against it."""
        if rng.random() < 0.6:
            half = np.minimum(rng.uniform(0.03, 0.2, 3), 0.5 * self.half)
            x, y = self.middle[:2] + rng.uniform(-0.9, 0.9, 2) * self.half[:2]
            bottom = self.high[2] * (1.0 if rng.random() < 0.5 else rng.uniform(0.3, 1.0))
            centre = np.array([x, y, bottom + half[2]])
            return RoomBox(centre, half, float(rng.uniform(0, pi)), CLUTTER)
        heading = rng.uniform(0, 2 * pi)
        direction = np.array([np.cos(heading), np.sin(heading)])
        half = np.array([rng.uniform(0.01, 0.08), *rng.uniform(0.1, 0.7, 2) * self.half[1:]])
        away = self.along(direction) + half[0] + rng.uniform(-0.05, 0.1)
        z = max(half[2], float(rng.uniform(0.2, 1.0) * self.high[2]))
        # The thin side faces the object.
        return RoomBox(np.append(self.middle[:2] + away * direction, z), half, heading, CLUTTER)
