"""Surroundings of a training object for ray casting: floor, walls, boxes and furniture.

Planes and boxes are intersected in closed form, without a search tree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

OBJECT, FLOOR, WALL, BOX, CLUTTER, FURNITURE, NOTHING = 0, 1, 2, 3, 4, 5, 255
"""Kinds of surfaces that rays hit."""
MAX_RANGE_M = np.float32(1e6)
"""Depth of rays without a hit [m]."""


@dataclass(frozen=True)
class Hits:
    """First hits of rays.

    Attributes:
        depth: (n,) float32 [m] distance in lengths of the rays.
        incidence: (n,) float32 [rad] between ray and surface normal, 0 … π/2.
        kind: (n,) uint8 `OBJECT`, `FLOOR`, `WALL`, `BOX`, `CLUTTER`, `FURNITURE` or `NOTHING`.
    """

    depth: NDArray[np.float32]
    incidence: NDArray[np.float32]
    kind: NDArray[np.uint8]

    def nearer(self, other: Hits) -> Hits:
        """The nearer of two hits of each ray."""
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
        """Whether a position is behind the wall, outside the room."""
        return float((position_xyz[:2] - self.point_xy) @ self.normal_xy) < 0.0

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """Hits of rays from inside the room."""
        normal = np.append(self.normal_xy, 0.0)
        offset = float((self.point_xy - origin_xyz[:2]) @ self.normal_xy)
        return _plane_hits(offset, rays_xyz, normal, WALL)


@dataclass(frozen=True)
class RoomBox:
    """An upright box, rotated about the vertical.

    Attributes:
        centre_xyz: (3,) [m] centre.
        half_xyz: (3,) [m] half of the edges.
        yaw: Rotation [rad].
        kind: `BOX`, or `CLUTTER` for a box that is segmented with the object.
    """

    centre_xyz: NDArray[np.float64]
    half_xyz: NDArray[np.float64]
    yaw: float
    kind: int = BOX

    def is_clear_of(self, position_xyz: NDArray[np.float64]) -> bool:
        """Whether a camera is clearly outside the box."""
        away = np.hypot(*(position_xyz[:2] - self.centre_xyz[:2]))
        return bool(away > np.hypot(*self.half_xyz[:2]) + 0.1)

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """Hits of rays from outside (the slab method)."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        R_box_map = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        start = (R_box_map @ (origin_xyz - self.centre_xyz)).astype(np.float32)
        along = R_box_map.astype(np.float32) @ rays_xyz.T
        entry, leave = np.full(len(rays_xyz), -MAX_RANGE_M), np.full(len(rays_xyz), MAX_RANGE_M)
        facing = np.zeros(len(rays_xyz), np.float32)
        # Axis by axis, since NumPy reduces rows of three slowly.
        for step, begin, half in zip(along, start, self.half_xyz.astype(np.float32), strict=True):
            safe = np.where(np.abs(step) < 1e-9, np.float32(1e-9), step)
            middle, reach = -begin / safe, half / np.abs(safe)
            later = middle - reach > entry
            facing = np.where(later, step, facing)
            entry = np.maximum(entry, middle - reach)
            leave = np.minimum(leave, middle + reach)
        hit = (entry < leave) & (entry > 0)
        return _hits(np.where(hit, entry, MAX_RANGE_M), facing, rays_xyz, self.kind)


class Thing(Protocol):
    """An object that rays can hit."""

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """First hits of rays, see `RoomSurroundings.hits`."""
        ...


@dataclass(frozen=True)
class RoomSurroundings:
    """Everything except the object; the floor is z = 0.

    Attributes:
        walls: Walls of the room.
        boxes: Boxes around the object.
        furniture: Furniture around the object, see `Neighbour`.
    """

    walls: tuple[Wall, ...] = ()
    boxes: tuple[RoomBox, ...] = ()
    furniture: tuple[Thing, ...] = ()

    def hits(self, origin_xyz: NDArray[np.float64], rays_xyz: NDArray[np.float32]) -> Hits:
        """First hits of rays on floor, walls, boxes and furniture.

        Args:
            origin_xyz: (3,) [m] origin of the rays.
            rays_xyz: (n, 3) directions of any length.
        """
        found = _plane_hits(-origin_xyz[2], rays_xyz, np.array([0.0, 0.0, 1.0]), FLOOR)
        for thing in (*self.walls, *self.boxes, *self.furniture):
            found = found.nearer(thing.hits(origin_xyz, rays_xyz))
        return found


def incidence_angles(
    rays_xyz: NDArray[np.float32], along_normal: NDArray[np.floating]
) -> NDArray[np.float32]:
    """(n,) incidence angles [rad] from the components of rays along unit normals."""
    lengths = np.sqrt(np.einsum("ij,ij->i", rays_xyz, rays_xyz))
    return np.arccos(np.clip(np.abs(along_normal) / lengths, 0.0, 1.0)).astype(np.float32)


def _plane_hits(
    offset: float, rays_xyz: NDArray[np.float32], normal: NDArray[np.float64], kind: int
) -> Hits:
    along = rays_xyz @ normal.astype(np.float32)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.float32(offset) / along
    return _hits(np.where(depth > 0, depth, MAX_RANGE_M), along, rays_xyz, kind)


def _hits(
    depth: NDArray[np.floating],
    along_normal: NDArray[np.floating],
    rays_xyz: NDArray[np.float32],
    kind: int,
) -> Hits:
    depth = np.where(np.isfinite(depth), depth, MAX_RANGE_M).astype(np.float32)
    kinds = np.where(depth < MAX_RANGE_M, kind, NOTHING).astype(np.uint8)
    return Hits(depth, incidence_angles(rays_xyz, along_normal), kinds)
