"""What stands round a training object: floor, walls, boxes and furniture, seen by the same rays.

Planes and boxes are intersected in closed form, so that a scene needs no search tree of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

OBJECT, FLOOR, WALL, BOX, CLUTTER, FURNITURE, NOTHING = 0, 1, 2, 3, 4, 5, 255
"""What a ray met first."""
FAR = np.float32(1e6)
"""Rays that meet nothing end here [m]."""


@dataclass(frozen=True)
class Hits:
    """First hits of rays.

    Attributes:
        depth: (n,) float32 [m] in lengths of the rays.
        incidence: (n,) float32 [rad] between ray and surface normal, 0 … π/2.
        kind: (n,) uint8 `OBJECT`, `FLOOR`, `WALL`, `BOX`, `CLUTTER`, `FURNITURE` or `NOTHING`.
    """

    depth: NDArray[np.float32]
    incidence: NDArray[np.float32]
    kind: NDArray[np.uint8]

    def nearer(self, other: Hits) -> Hits:
        """The first of two hits of each ray."""
        first = self.depth <= other.depth
        return Hits(
            np.where(first, self.depth, other.depth),
            np.where(first, self.incidence, other.incidence),
            np.where(first, self.kind, other.kind),
        )


@dataclass(frozen=True)
class Wall:
    """A vertical plane.

    Attributes:
        point_xy: (2,) [m] a point on it.
        normal_xy: (2,) unit vector into the room.
    """

    point_xy: NDArray[np.float64]
    normal_xy: NDArray[np.float64]

    def is_behind(self, position_xyz: NDArray[np.float64]) -> bool:
        """Whether a place lies behind the wall, outside of the room."""
        return float((position_xyz[:2] - self.point_xy) @ self.normal_xy) < 0.0

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """Where rays from inside of the room meet it."""
        normal = np.append(self.normal_xy, 0.0)
        offset = float((self.point_xy - origin_xyz[:2]) @ self.normal_xy)
        return _plane_hits(offset, rays_xyz, normal, WALL)


@dataclass(frozen=True)
class Box:
    """A box that stands or hangs upright, turned about the vertical.

    Attributes:
        centre_xyz: (3,) [m].
        half_xyz: (3,) [m] half of its edges.
        yaw: [rad].
        kind: `BOX`, or `CLUTTER` for what a segmentation takes for a part of the object.
    """

    centre_xyz: NDArray[np.float64]
    half_xyz: NDArray[np.float64]
    yaw: float
    kind: int = BOX

    def is_clear_of(self, position_xyz: NDArray[np.float64]) -> bool:
        """Whether a camera is outside of it, with room to spare."""
        away = np.hypot(*(position_xyz[:2] - self.centre_xyz[:2]))
        return bool(away > np.hypot(*self.half_xyz[:2]) + 0.1)

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """Where rays from outside enter it (the slab method)."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        R_box_map = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        start = (R_box_map @ (origin_xyz - self.centre_xyz)).astype(np.float32)
        along = R_box_map.astype(np.float32) @ rays_xyz.T
        entry, leave = np.full(len(rays_xyz), -FAR), np.full(len(rays_xyz), FAR)
        facing = np.zeros(len(rays_xyz), np.float32)
        # One axis at a time: NumPy reduces rows of three slowly.
        for step, begin, half in zip(along, start, self.half_xyz.astype(np.float32), strict=True):
            safe = np.where(np.abs(step) < 1e-9, np.float32(1e-9), step)
            middle, reach = -begin / safe, half / np.abs(safe)
            later = middle - reach > entry
            facing = np.where(later, step, facing)
            entry = np.maximum(entry, middle - reach)
            leave = np.minimum(leave, middle + reach)
        hit = (entry < leave) & (entry > 0)
        return _hits(np.where(hit, entry, FAR), facing, rays_xyz, self.kind)


class Thing(Protocol):
    """Something that rays meet."""

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """First hits of rays, see `Surroundings.hits`."""
        ...


@dataclass(frozen=True)
class Surroundings:
    """All that is not the object; the floor is z = 0.

    Attributes:
        walls: See `Wall`.
        boxes: See `Box`.
        furniture: See `Neighbour`.
    """

    walls: tuple[Wall, ...] = ()
    boxes: tuple[Box, ...] = ()
    furniture: tuple[Thing, ...] = ()

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """First hits of rays on floor, walls, boxes and furniture.

        Args:
            origin_xyz: (3,) [m] where the rays begin.
            rays_xyz: (n, 3) directions of any length.
        """
        found = _plane_hits(-origin_xyz[2], rays_xyz, np.array([0.0, 0.0, 1.0]), FLOOR)
        for thing in (*self.walls, *self.boxes, *self.furniture):
            found = found.nearer(thing.hits(origin_xyz, rays_xyz))
        return found


def incidence_angles(
    rays_xyz: NDArray[np.float32], along_normal: NDArray[np.floating]
) -> NDArray[np.float32]:
    """(n,) [rad] from the components of rays along unit normals."""
    lengths = np.sqrt(np.einsum("ij,ij->i", rays_xyz, rays_xyz))
    return np.arccos(np.clip(np.abs(along_normal) / lengths, 0.0, 1.0)).astype(np.float32)


def _plane_hits(
    offset: float, rays_xyz: NDArray[np.float32], normal: NDArray[np.float64], kind: int
) -> Hits:
    along = rays_xyz @ normal.astype(np.float32)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.float32(offset) / along
    return _hits(np.where(depth > 0, depth, FAR), along, rays_xyz, kind)


def _hits(
    depth: NDArray[np.floating],
    along_normal: NDArray[np.floating],
    rays_xyz: NDArray[np.float32],
    kind: int,
) -> Hits:
    depth = np.where(np.isfinite(depth), depth, FAR).astype(np.float32)
    kinds = np.where(depth < FAR, kind, NOTHING).astype(np.uint8)
    return Hits(depth, incidence_angles(rays_xyz, along_normal), kinds)
