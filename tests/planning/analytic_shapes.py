"""Shapes whose normals are known, and what a camera sees of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.planning import (
    Finished,
    NextView,
    PlannerInput,
    ViewPlanner,
    base_pose,
    camera_place,
    footprint,
)

CAMERA = PinholeCamera.xtion()
TILT = np.radians(30.0)
MOUNT = RigidTransform.from_components(
    [0.0, 0.165, 1.2],
    Rotation.from_matrix(
        np.column_stack(
            [[1, 0, 0], [0, -np.sin(TILT), -np.cos(TILT)], [0, np.cos(TILT), -np.sin(TILT)]]
        )
    ),
)
HEIGHTS = np.arange(0.04, 0.62, 0.04)
HALF_VIEW = np.arctan(CAMERA.width / 2 / CAMERA.fx)


@dataclass(frozen=True)
class Shape:
    """Upright walls over an outline: (n, 2) places with their outward normals."""

    outline_xy: NDArray[np.float64]
    normals_xy: NDArray[np.float64]

    def seen_from(self, eye: PlanarPose, noise: float = 0.0, seed: int = 0):
        """(k,) indices of the outline that a camera sees, and the (k, 2) places it measures."""
        sight = eye.xy - self.outline_xy
        away = np.linalg.norm(sight, axis=1)
        facing = np.einsum("ij,ij->i", sight, self.normals_xy) / away > np.cos(np.radians(80))
        bearing = np.arctan2(-sight[:, 1], -sight[:, 0]) - eye.yaw
        bearing = (bearing + np.pi) % (2 * np.pi) - np.pi
        bins = np.round(bearing / np.radians(0.5)).astype(int)
        nearest = {b: away[bins == b].min() for b in np.unique(bins)}
        free = away <= np.array([nearest[b] for b in bins]) + 0.03
        visible = np.flatnonzero(facing & free & (np.abs(bearing) < HALF_VIEW))
        jitter = np.random.default_rng(seed).normal(0, noise, (len(visible), 2)) if noise else 0.0
        return visible, self.outline_xy[visible] + jitter

    def normals_near(self, place_xy, within: float = 0.1) -> NDArray[np.float64]:
        """(k, 2) normals of the walls at a place: those of both sides at a corner."""
        away = np.linalg.norm(self.outline_xy - place_xy, axis=1)
        return self.normals_xy[away <= max(within, away.min())]


def circle(radius: float) -> Shape:
    angles = np.arange(0, 2 * np.pi, 0.01 / radius)
    normals = np.column_stack([np.cos(angles), np.sin(angles)])
    return Shape(radius * normals, normals)


def polygon(*corners: tuple[float, float]) -> Shape:
    """Corners counter-clockwise."""
    places, normals = [], []
    ends = np.array(corners, float)
    for a, b in zip(ends, np.roll(ends, -1, axis=0), strict=True):
        along = (b - a) / np.linalg.norm(b - a)
        steps = np.arange(0.005, np.linalg.norm(b - a), 0.01)
        places.append(a + steps[:, None] * along)
        normals.append(np.tile([along[1], -along[0]], (len(steps), 1)))
    return Shape(np.vstack(places), np.vstack(normals))


def box(width: float, depth: float) -> Shape:
    w, d = width / 2, depth / 2
    return polygon((-w, -d), (w, -d), (w, d), (-w, d))


def l_shape() -> Shape:
    return polygon((-0.6, -0.6), (0.6, -0.6), (0.6, 0.0), (0.0, 0.0), (0.0, 0.6), (-0.6, 0.6))


def walls(outline_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) the outline at all heights."""
    flat = np.repeat(outline_xy, len(HEIGHTS), axis=0)
    return np.column_stack([flat, np.tile(HEIGHTS, len(outline_xy))])


def planner_input(points_xyz: NDArray[np.float64], base: PlanarPose, **more) -> PlannerInput:
    return PlannerInput(
        points_xyz=points_xyz,
        normals_xyz=np.zeros_like(points_xyz),
        footprint_xy=footprint(points_xyz),
        T_map_base=base,
        camera=CAMERA,
        **{"T_base_camera": MOUNT, "depth_range": (0.8, 3.5), **more},
    )


def facing_centre(azimuth: float, away: float) -> PlanarPose:
    """The base of a camera that looks at the origin from a place."""
    return base_pose(away * np.array([np.cos(azimuth), np.sin(azimuth)]), (0.0, 0.0), MOUNT)


def tour(
    shape: Shape, planner: ViewPlanner, start: PlanarPose, noise: float = 0.0, most: int = 40
) -> Iterator[tuple[PlannerInput, NextView | Finished]]:
    """The views of a planner in sequence; the robot is placed at each."""
    known = np.empty((0, 2))
    visited = [start]
    for number in range(most):
        base = visited[-1]
        _, places = shape.seen_from(camera_place(base, MOUNT), noise, number)
        known = np.vstack([known, places])
        asked = planner_input(walls(known), base, visited=tuple(visited))
        answer = planner.next_view(asked)
        yield asked, answer
        if isinstance(answer, Finished):
            return
        visited += _between(base, answer.T_map_base, np.zeros(2))
    raise AssertionError(f"not finished after {most} views")


def _between(start: PlanarPose, end: PlanarPose, centre: NDArray[np.float64]) -> list[PlanarPose]:
    """Poses on the way, counter-clockwise round a centre."""
    a, b = start.xy - centre, end.xy - centre
    first, radius = np.arctan2(a[1], a[0]), np.linalg.norm(a)
    turn = np.mod(np.arctan2(b[1], b[0]) - first, 2 * np.pi)
    turn -= 2 * np.pi * (turn > 1.9 * np.pi)
    shares = np.linspace(0, 1, 12)[1:-1]
    bearings = first + shares * turn
    radii = radius + shares * (np.linalg.norm(b) - radius)
    places = centre + radii[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    return [*(PlanarPose(x, y, end.yaw) for x, y in places), end]


def turned_back(base: PlanarPose, by: float) -> PlanarPose:
    return replace(base, yaw=base.yaw + by)
