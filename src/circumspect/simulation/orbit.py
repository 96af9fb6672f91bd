"""The orbit of the robot's camera around an object, and the mount of the camera."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.planning import MAX_IMAGE_FRACTION, SURFACE_DISTANCE_M
from circumspect.robot import DifferentialDrive
from circumspect.sensing import DepthNoise
from circumspect.sensing.viewing import looking
from circumspect.simulation.station import Station, looking_at

MAST_HEIGHT = 1.2
"""Height of the camera above the floor [m]; on a mast it sees seats and table tops."""
MIN_MAST_HEIGHT_M, MAX_MAST_HEIGHT_M = 0.05, 5.0
"""Range of heights for which the camera is above the robot and the floor is within range [m]."""
SPEED = 0.05
"""The robot's speed [m/s] (section 3.1)."""
MIN_OBJECT_SIZE_M = 0.1
"""Minimum size of an object [m]; smaller ones have too few pixels."""
RANGE_MARGIN_M = 0.05
"""Margin of the nearest point over the minimum range of the sensor, for noise [m]."""


@dataclass(frozen=True)
class CameraMount:
    """Mount of a camera on a mast over the left wheel, facing left and down.

    Attributes:
        height: Height of the camera above the floor [m].
        tilt: Downward angle [rad].
        left: Distance to the left of `base_link` [m].

    Raises:
        InputError: The mast is too low or too high, or the camera faces straight up or down or is
            not above the robot.
    """

    height: float = MAST_HEIGHT
    tilt: float = float(np.radians(30.0))
    left: float = DifferentialDrive().track / 2

    def __post_init__(self) -> None:
        require_mast(self.height)
        if not abs(self.tilt) < np.pi / 2:
            tilt = np.degrees(self.tilt)
            raise InputError(f"a camera on a mast is tilted by less than 90°, not by {tilt:g}°")
        if not abs(self.left) < 1:
            raise InputError(
                f"the mast must be on the robot, not {self.left:g} m beside its centre"
            )

    @classmethod
    def for_orbit(cls, orbit: Orbit) -> CameraMount:
        """The mount whose camera looks at the target of an orbit."""
        drop = orbit.height - orbit.target_height
        return cls(orbit.height, float(np.arctan2(drop, orbit.radius)))

    @property
    def T_base_camera(self) -> RigidTransform:
        """Pose of the camera on the robot, optical frame; its x axis points forward."""
        return looking([0.0, self.left, self.height], np.pi / 2, self.tilt)


@dataclass(frozen=True)
class Orbit:
    """A level circle about a vertical axis, driven with the object on the left.

    Attributes:
        radius: Radius of the circle [m].
        height: Height of the camera above the floor [m].
        target_height: Height of the point on the axis that the camera looks at [m].
        start: Azimuth of the first station [rad].
        centre_xy: Position of the axis [m].
        speed: Speed along the circle [m/s].

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
        """The smallest circle from which the whole object is in the image and in range.

        Small objects are circled at the paper's distance, measured horizontally from the outermost
        point; larger ones at the distance that the field of view requires.

        Args:
            mesh: The object, map frame [m].
            camera: The camera.
            start: Azimuth of the first station [rad].
            height: Height of the camera [m].
            noise: Depth noise, which defines the range of the camera.

        Raises:
            InputError: The object is too large (out of range where it fits the image) or too small,
                or the camera is lower or higher than a mast can be.
        """
        sensor = noise or DepthNoise()
        low, high = mesh.vertices_xyz.min(axis=0), mesh.vertices_xyz.max(axis=0)
        if (high - low).max() < MIN_OBJECT_SIZE_M:
            raise InputError(
                f"the object is {1e3 * (high - low).max():.2g} mm at its longest, too small for "
                f"the camera, which needs {MIN_OBJECT_SIZE_M:g} m; are its units metres?"
            )
        centre = (low + high) / 2
        points = _outline(mesh.vertices_xyz - [centre[0], centre[1], 0.0])
        reach = float(np.hypot(points[:, 0], points[:, 1]).max())
        nearest = sensor.nearest + RANGE_MARGIN_M
        for radius in np.arange(reach + SURFACE_DISTANCE_M, reach + sensor.farthest, 0.02):
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
        """The station at `angle` [rad] counter-clockwise from the start."""
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
        """Endless sequence of stations, `count` per round, evenly spaced."""
        index = 0
        while True:
            yield self.station(2 * np.pi * index / count)
            index += 1


def require_mast(height: float) -> None:
    """Check that a robot can carry a camera at a height [m].

    Raises:
        InputError: It cannot.
    """
    if not MIN_MAST_HEIGHT_M <= height <= MAX_MAST_HEIGHT_M:
        raise InputError(
            f"a mast is from {MIN_MAST_HEIGHT_M:g} to {MAX_MAST_HEIGHT_M:g} m high, not "
            f"{height:g} m"
        )


def _outline(points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """The outermost points of the object for every height and azimuth."""
    headings = np.arange(72) * (2 * np.pi / 72)
    directions = np.column_stack([np.cos(headings), np.sin(headings)])
    tilts = np.linspace(-3.0, 3.0, 13)
    chosen = {int(np.argmax(points_xyz @ [x, y, tilt])) for x, y in directions for tilt in tilts}
    chosen |= {int(np.argmin(points_xyz[:, 2])), int(np.argmax(points_xyz[:, 2]))}
    return points_xyz[sorted(chosen)]


def _target_height(points_xyz: NDArray[np.float64], radius: float, height: float) -> float:
    """Height on the axis at which the object is equally far from the upper and lower image edge."""
    reach = np.hypot(points_xyz[:, 0], points_xyz[:, 1])
    # Each point is nearest at one position of the orbit and farthest at another.
    distances = np.concatenate([radius - reach, radius + reach])
    drop = np.tile(height - points_xyz[:, 2], 2)
    angles = np.arctan2(drop, np.maximum(distances, 1e-3))
    return float(height - radius * np.tan((angles.min() + angles.max()) / 2))


def _in_view(
    orbit: Orbit, points_xyz: NDArray[np.float64], camera: PinholeCamera, nearest: float
) -> bool:
    points = points_xyz + np.array([*orbit.centre_xy, 0.0])
    half_u, half_v = MAX_IMAGE_FRACTION * camera.width / 2, MAX_IMAGE_FRACTION * camera.height / 2
    for angle in np.arange(36) * (2 * np.pi / 36):
        x, y, z = orbit.station(float(angle)).T_map_camera.inv().apply(points).T
        if z.min() < nearest:
            return False
        u, v = camera.fx * x / z, camera.fy * y / z
        if np.abs(u).max() > half_u or np.abs(v).max() > half_v:
            return False
    return True
