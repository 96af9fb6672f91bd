"""The circle on which the robot's camera goes round an object."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.planning import IMAGE_SHARE, SURFACE_DISTANCE
from circumspect.sensing import DepthNoise
from circumspect.simulation.station import Station, looking_at

MAST_HEIGHT = 1.2
"""Height of the camera above the floor [m]: on a mast, so that it sees seats and table tops."""
LOWEST_MAST, HIGHEST_MAST = 0.05, 5.0
"""Within these the camera is above the robot's hull, and the floor within its range [m]."""
SPEED = 0.05
"""The robot's speed [m/s] (section 3.1)."""
SMALLEST = 0.1
"""What is smaller in all directions has too few pixels to be modelled [m]."""
CLEARANCE = 0.05
"""What the nearest point stays beyond the sensor's shortest range [m]: noise would lose it."""


@dataclass(frozen=True)
class Orbit:
    """A level circle about a vertical axis, driven with the object on the left.

    Attributes:
        radius: Of the circle [m].
        height: Of the camera above the floor [m].
        target_height: Height of the point on the axis that the camera looks at [m].
        start: Azimuth of the first station [rad].
        centre_xy: The axis [m].
        speed: Along the circle [m/s].

    Raises:
        InputError: The camera is lower or higher than a mast can be.
    """

    radius: float
    height: float = MAST_HEIGHT
    target_height: float = 0.4
    start: float = 0.0
    centre_xy: tuple[float, float] = (0.0, 0.0)
    speed: float = SPEED

    def __post_init__(self) -> None:
        require_mast(self.height)

    @classmethod
    def around(
        cls,
        mesh: TriangleMesh,
        camera: PinholeCamera,
        start: float = 0.0,
        height: float = MAST_HEIGHT,
        noise: DepthNoise | None = None,
    ) -> Orbit:
        """The smallest circle from which the whole object is in the picture and in range.

        Small objects are circled at the paper's distance, measured level from the outermost
        point; larger ones as far away as the field of view asks for.

        Args:
            mesh: The object, map frame [m].
            camera: The camera.
            start: Azimuth of the first station [rad].
            height: Of the camera [m].
            noise: Gives the camera's range.

        Raises:
            InputError: The object is too large: where it fits the picture it is out of range; or
                too small to be modelled; or the camera is lower or higher than a mast can be.
        """
        sensor = noise or DepthNoise()
        low, high = mesh.vertices_xyz.min(axis=0), mesh.vertices_xyz.max(axis=0)
        if (high - low).max() < SMALLEST:
            raise InputError(
                f"the object is {1e3 * (high - low).max():.2g} mm at its longest, too small for "
                f"the camera, which needs {SMALLEST:g} m; are its units metres?"
            )
        centre = (low + high) / 2
        points = _outline(mesh.vertices_xyz - [centre[0], centre[1], 0.0])
        reach = float(np.hypot(points[:, 0], points[:, 1]).max())
        nearest = sensor.nearest + CLEARANCE
        for radius in np.arange(reach + SURFACE_DISTANCE, reach + sensor.farthest, 0.02):
            target = _target_height(points, radius, height)
            orbit = cls(float(radius), height, target, start, (float(centre[0]), float(centre[1])))
            if _in_view(orbit, points, camera, nearest):
                return orbit
        raise InputError(
            f"the object of {high[0] - low[0]:.1f} x {high[1] - low[1]:.1f} x "
            f"{high[2] - low[2]:.1f} m is too large to be seen whole within the camera's range of "
            f"{sensor.farthest} m; are its units metres?"
        )

    def station(self, angle: float) -> Station:
        """The station after `angle` [rad] of the way round, counter-clockwise from the start."""
        azimuth = self.start + angle
        x, y = self.centre_xy
        position = (
            x + self.radius * np.cos(azimuth),
            y + self.radius * np.sin(azimuth),
            self.height,
        )
        pose = looking_at(position, (x, y, self.target_height))
        return Station(abs(angle) * self.radius / self.speed, pose)

    def stations(self, count: int) -> Iterator[Station]:
        """`count` stations a round, evenly spaced, for ever."""
        index = 0
        while True:
            yield self.station(2 * np.pi * index / count)
            index += 1


def require_mast(height: float) -> None:
    """Check that a robot can carry a camera so high [m].

    Raises:
        InputError: It can not.
    """
    if not LOWEST_MAST <= height <= HIGHEST_MAST:
        raise InputError(
            f"a mast is from {LOWEST_MAST:g} to {HIGHEST_MAST:g} m high, not {height:g} m"
        )


def _outline(points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points that bound the object: for every height and heading the outermost."""
    headings = np.arange(72) * (2 * np.pi / 72)
    directions = np.column_stack([np.cos(headings), np.sin(headings)])
    tilts = np.linspace(-3.0, 3.0, 13)
    chosen = {int(np.argmax(points_xyz @ [x, y, tilt])) for x, y in directions for tilt in tilts}
    chosen |= {int(np.argmin(points_xyz[:, 2])), int(np.argmax(points_xyz[:, 2]))}
    return points_xyz[sorted(chosen)]


def _target_height(points_xyz: NDArray[np.float64], radius: float, height: float) -> float:
    """Where on the axis to look so that the object is as far from the upper as the lower rim."""
    reach = np.hypot(points_xyz[:, 0], points_xyz[:, 1])
    # From somewhere on the circle each point is at its nearest, and elsewhere at its farthest.
    distances = np.concatenate([radius - reach, radius + reach])
    drop = np.tile(height - points_xyz[:, 2], 2)
    angles = np.arctan2(drop, np.maximum(distances, 1e-3))
    return float(height - radius * np.tan((angles.min() + angles.max()) / 2))


def _in_view(
    orbit: Orbit, points_xyz: NDArray[np.float64], camera: PinholeCamera, nearest: float
) -> bool:
    points = points_xyz + np.array([*orbit.centre_xy, 0.0])
    half_u, half_v = IMAGE_SHARE * camera.width / 2, IMAGE_SHARE * camera.height / 2
    for angle in np.arange(36) * (2 * np.pi / 36):
        x, y, z = orbit.station(float(angle)).T_map_camera.inv().apply(points).T
        if z.min() < nearest:
            return False
        u, v = camera.fx * x / z, camera.fy * y / z
        if np.abs(u).max() > half_u or np.abs(v).max() > half_v:
            return False
    return True
