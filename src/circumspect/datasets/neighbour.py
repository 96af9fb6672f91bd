"""A piece of furniture that stands next to a training object, under or over it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.surroundings import FURNITURE, NOTHING, Hits
from circumspect.furniture import CATEGORIES, make_furniture

FIRST_SEED = 2_000_000
"""Of the pieces; furniture that trains, that is held back and that is measured lies below."""
EACH = 8
"""Pieces of each category."""
GAPS = (-0.7, 0.3)
"""From the object's box to the piece's, in units of the piece's half depth; below 0 they overlap,
as a table and the chair at it do."""


@dataclass(frozen=True)
class Neighbour:
    """Furniture that stands on the floor, turned about the vertical.

    Attributes:
        caster: Its surface, about the z axis.
        middle_xy: (2,) [m] where it stands.
        yaw: [rad].
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
        """Place a random piece at an object.

        Args:
            low_xyz: (3,) [m] smallest coordinates of the object.
            high_xyz: (3,) [m] largest.
            rng: Source of all chance.
        """
        category = str(rng.choice(list(CATEGORIES)))
        caster = _piece(category, int(rng.integers(EACH)))
        bearing, yaw = rng.uniform(0, 2 * pi, 2)
        direction = np.array([cos(bearing), sin(bearing)])
        half_xy = np.ptp(caster.corners_xyz, axis=0)[:2] / 2
        # Half of what it measures along the direction, in its own frame.
        own = _turned(direction, -yaw)
        depth = float(np.abs(own * half_xy).sum())
        away = float(np.abs(direction * (high_xyz - low_xyz)[:2] / 2).sum())
        away += depth * (1 + rng.uniform(*GAPS))
        middle = (low_xyz + high_xyz)[:2] / 2
        return cls(caster, middle + away * direction, float(yaw))

    def is_clear_of(self, position_xyz: NDArray[np.float64]) -> bool:
        """Whether a camera is outside of it, with room to spare."""
        away = float(np.hypot(*(position_xyz[:2] - self.middle_xy)))
        return away > float(np.hypot(*self.caster.corners_xyz[1, :2])) + 0.1

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """First hits of rays on it, see `Surroundings.hits`."""
        origin = np.append(_turned(origin_xyz[:2] - self.middle_xy, -self.yaw), origin_xyz[2])
        rays = np.column_stack([_turned(rays_xyz[:, :2], -self.yaw), rays_xyz[:, 2]])
        found = self.caster.hits(origin, rays.astype(np.float32), np.ones(3))
        kind = np.where(found.kind == NOTHING, NOTHING, FURNITURE).astype(np.uint8)
        return replace(found, kind=kind)


@cache
def _piece(category: str, number: int) -> ObjectCaster:
    return ObjectCaster(make_furniture(category, FIRST_SEED + number))


def _turned(xy: NDArray[np.floating], yaw: float) -> NDArray[np.float64]:
    """(…, 2) turned about the vertical."""
    return xy.astype(np.float64) @ np.array([[cos(yaw), sin(yaw)], [-sin(yaw), cos(yaw)]])
