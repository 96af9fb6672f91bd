"""A furnished room around an object."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.geometry import PinholeCamera, PlanarPose, TriangleMesh
from circumspect.sensing import DepthNoise
from circumspect.simulation import pioneer
from circumspect.simulation.orbit import MAST_HEIGHT, CameraMount, Orbit
from circumspect.simulation.scene import Scene, Surface, block, cylinder, moved_mesh

WALL_HEIGHT, WALL_THICKNESS = 2.4, 0.1
"""Height and thickness of walls [m]."""
CLUTTER = ("night_stand", "chair", "toilet")
"""Categories of furniture that is small enough for clutter."""
MAX_ATTEMPTS = 60


@dataclass(frozen=True, eq=False)
class Room:
    """A scene with a free lane around its object.

    Attributes:
        scene: The surfaces: "object", "floor", "wall-0" to "wall-3" (the first is the near one),
            "box-1", "plant-2", …
        orbit: An orbit from which the camera sees the whole object.
        mount: Mount of a camera that looks at the object from the orbit.
        lane_radius: Distance from the orbit's axis within which there is only the object [m].
    """

    scene: Scene
    orbit: Orbit
    mount: CameraMount
    lane_radius: float

    def start(self, azimuth_deg: float) -> PlanarPose:
        """`T_map_base` of a robot on the circle with the object on its left.

        Args:
            azimuth_deg: Azimuth of the robot as seen from the object, counter-clockwise from +x
                [degrees].

        Raises:
            InputError: The azimuth is not finite.
        """
        if not np.isfinite(azimuth_deg):
            raise InputError(f"the start azimuth is {azimuth_deg}; give degrees")
        azimuth = float(np.radians(azimuth_deg))
        radius = self.orbit.radius + self.mount.left
        x, y = self.orbit.centre_xy
        return PlanarPose(
            x + radius * np.cos(azimuth), y + radius * np.sin(azimuth), azimuth + np.pi / 2
        )


def room(
    mesh: TriangleMesh,
    seed: int = 0,
    camera: PinholeCamera | None = None,
    height: float = MAST_HEIGHT,
    noise: DepthNoise | None = None,
    clutter: int = 4,
    margin: float = 0.15,
) -> Room:
    """Create walls, a floor and clutter around an object.

    The room has a random orientation. Its near wall is just outside the lane, the other walls up to
    1.8 m farther away, and clutter between them and the lane.

    Args:
        mesh: The object [m], standing on z = 0.
        seed: Seed of all random numbers.
        camera: Camera that the lane is designed for; None means the Xtion PRO.
        height: Height of the camera above the floor [m].
        noise: Depth noise, which defines the range of the camera.
        clutter: Number of other objects; fewer if there is no space.
        margin: Free space of the lane beside the robot on its circle [m].

    Raises:
        InputError: The object is too large for the camera; see `Orbit.around`.
    """
    orbit = Orbit.around(mesh, camera or PinholeCamera.xtion(), height=height, noise=noise)
    mount = CameraMount.for_orbit(orbit)
    lane = orbit.radius + mount.left + pioneer.RADIUS + margin
    rng = np.random.default_rng(seed)
    wall_distances = lane + np.concatenate([[0.05], rng.uniform(0.8, 1.8, 3)])
    things = [*_walls(wall_distances), *_clutter(rng, wall_distances, lane, clutter)]
    turn = PlanarPose(*orbit.centre_xy, float(rng.uniform(0, 2 * np.pi)))
    others = [Surface(s.name, moved_mesh(s.mesh, turn), s.colour) for s in things]
    return Room(Scene.with_object(mesh, *others), orbit, mount, lane)


def _walls(wall_distances: NDArray[np.float64]) -> Iterator[Surface]:
    """Walls with inner faces at given distances from the origin along +x, +y, -x, -y."""
    t, h = WALL_THICKNESS, WALL_HEIGHT
    e, n, w, s = (float(reach) for reach in wall_distances)
    yield Surface("wall-0", block((e, -s - t, 0), (e + t, n + t, h)), (0.86, 0.84, 0.78))
    yield Surface("wall-1", block((-w, n, 0), (e, n + t, h)), (0.80, 0.84, 0.80))
    yield Surface("wall-2", block((-w - t, -s - t, 0), (-w, n + t, h)), (0.84, 0.80, 0.82))
    yield Surface("wall-3", block((-w, -s - t, 0), (e, -s, h)), (0.78, 0.82, 0.86))


def _clutter(
    rng: np.random.Generator, wall_distances: NDArray[np.float64], lane: float, count: int
) -> Iterator[Surface]:
    """Objects between the lane and the walls, without overlap."""
    placed: list[tuple[float, float, float]] = []
    makers = (_box, _plant, _furniture, _box)
    for _ in range(MAX_ATTEMPTS):
        if len(placed) == count:
            return
        number = len(placed) + 1
        name, mesh, colour = makers[len(placed) % len(makers)](rng)
        reach = float(np.hypot(*mesh.vertices_xyz[:, :2].T).max())
        azimuth = rng.uniform(0, 2 * np.pi)
        distance = lane + reach + rng.uniform(0.0, 0.3)
        x, y = distance * np.cos(azimuth), distance * np.sin(azimuth)
        e, n, w, s = wall_distances
        inside = x + reach < e and y + reach < n and x - reach > -w and y - reach > -s
        if inside and all(np.hypot(x - a, y - b) > reach + c for a, b, c in placed):
            placed.append((x, y, reach))
            stand = PlanarPose(x, y, float(rng.uniform(0, 2 * np.pi)))
            yield Surface(f"{name}-{number}", moved_mesh(mesh, stand), colour)


_Thing = tuple[str, TriangleMesh, tuple[float, float, float]]


def _box(rng: np.random.Generator) -> _Thing:
    a, b, h = rng.uniform([0.10, 0.10, 0.2], [0.28, 0.28, 0.9])
    return "box", block((-a, -b, 0.0), (a, b, h)), (0.72, 0.60, 0.42)


def _plant(rng: np.random.Generator) -> _Thing:
    pot = cylinder(float(rng.uniform(0.12, 0.18)), 0.0, 0.35)
    crown = cylinder(float(rng.uniform(0.18, 0.30)), 0.40, float(rng.uniform(0.9, 1.5)))
    stem = cylinder(0.03, 0.30, 0.45)
    return "plant", _joined(pot, stem, crown), (0.36, 0.58, 0.34)


def _furniture(rng: np.random.Generator) -> _Thing:
    category = str(rng.choice(CLUTTER))
    return category, make_furniture(category, int(rng.integers(2**31))), (0.50, 0.46, 0.58)


def _joined(*parts: TriangleMesh) -> TriangleMesh:
    starts = np.cumsum([0] + [len(part.vertices_xyz) for part in parts[:-1]])
    return TriangleMesh(
        np.concatenate([part.vertices_xyz for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]),
    )
