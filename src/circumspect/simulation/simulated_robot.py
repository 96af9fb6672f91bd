"""A Pioneer 3-DX in a simulated room."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.geometry.composition import composed
from circumspect.robot import DifferentialDrive, MobileRobot, Velocity, WheelOdometry
from circumspect.sensing import DepthNoise, Odometry
from circumspect.simulation import pioneer
from circumspect.simulation.camera_mount import CameraMount
from circumspect.simulation.depth_distortion import DepthDistortion
from circumspect.simulation.obstacles import footprint_boxes
from circumspect.simulation.robot_physics import TICK, RobotPhysics
from circumspect.simulation.scene import Scene
from circumspect.simulation.simulated_camera import SimulatedCamera
from circumspect.simulation.station import Station
from circumspect.simulation.wheel_slip import WheelSlip

TICKS_PER_READING = 5
"""The odometry reads the encoders every so many ticks: ten times a second, as the robot does."""


@dataclass(frozen=True)
class RobotSettings:
    """How far the robot and its floor are from the ideal.

    Attributes:
        slip: Share of the wheels' travel that does not become motion; see `WheelSlip`.
        expected_slip: What the odometry takes off for slip, as found by a calibration drive. 0
            is a robot that does not know its floor: its odometry then claims too much way.
        wheel_radius_error: Share by which the right wheel is larger than the left, while the
            odometry believes both to be equal: the robot drifts to the left.
        bump_height: The highest ridge on the floor [m]; up to 0.02 m the robot gets over.

    Raises:
        InputError: A value makes no sense.
    """

    slip: float = 0.0
    expected_slip: float = 0.0
    wheel_radius_error: float = 0.0
    bump_height: float = 0.0

    def __post_init__(self) -> None:
        for share in (self.slip, self.expected_slip):
            if not 0 <= share <= 0.5:
                raise InputError(f"slip is a share from 0 to 0.5, not {share}")
        if not abs(self.wheel_radius_error) <= 0.2:
            raise InputError(f"wheels differ by at most 0.2, not {self.wheel_radius_error}")
        if not 0 <= self.bump_height <= 0.05:
            raise InputError(f"bumps are from 0 to 0.05 m high, not {self.bump_height} m")


@dataclass(frozen=True)
class Truth:
    """What the robot can not know; for measurements only.

    Attributes:
        stamp: Time [s].
        T_map_camera: The true pose of the camera, with the base's tilt.
        T_map_base: The true pose of the base.
    """

    stamp: float
    T_map_camera: RigidTransform
    T_map_base: RigidTransform


class SimulatedRobot(MobileRobot):
    """See `MobileRobot`; physics by MuJoCo, depth by Embree, deterministic by seed."""

    def __init__(
        self,
        scene: Scene,
        start: PlanarPose,
        mount: CameraMount | None = None,
        settings: RobotSettings | None = None,
        intrinsics: PinholeCamera | None = None,
        noise: DepthNoise | None = None,
        seed: int = 0,
        colour: bool = False,
        real_time: float | None = None,
        distortion: DepthDistortion | None = None,
    ) -> None:
        """Put a robot into a scene.

        Args:
            scene: What it sees and bumps into.
            start: Where it stands first, map frame.
            mount: Of its camera.
            settings: Slip, wheels and floor.
            intrinsics: Of its camera; None means the Xtion PRO.
            noise: Of its depth; None means exact depth.
            seed: Of all chance.
            colour: Make shaded colour images, too.
            real_time: Seconds simulated in each second at most; None means as fast as it goes.
            distortion: Of its depth; None means none.

        Raises:
            InputError: `real_time` is not positive, or the distortion is that of another image
                size.
            MissingExtraError: Embree or MuJoCo is not installed.
        """
        if real_time is not None and not 0 < real_time < np.inf:
            raise InputError(f"real time goes by a positive factor, not {real_time}")
        self.mount = mount or CameraMount()
        self.settings = settings or RobotSettings()
        self._drive = DifferentialDrive()
        depth_rng, slip_rng, floor_rng = np.random.default_rng(seed).spawn(3)
        height = self.mount.height + 0.05
        mjcf = pioneer.world(
            self.settings,
            self._drive,
            footprint_boxes(scene, height),
            height,
            start.xy,
            floor_rng,
        )
        slip = WheelSlip(self.settings.slip, slip_rng)
        self._physics = RobotPhysics(mjcf, self._drive, slip, start)
        self._wheels = WheelOdometry(self._drive, self.settings.expected_slip)
        self._odometry = self._wheels.update(0.0, *self._physics.encoders)
        self._T_base_camera = self.mount.T_base_camera
        station = partial(_station, self._physics, self._T_base_camera)
        self._camera = SimulatedCamera(
            scene, station, intrinsics, noise, depth_rng, colour, False, distortion
        )
        self._wanted = Velocity()
        self._ticks = 0
        self._due = 0.0
        self._real_time = real_time

    @property
    def camera(self) -> SimulatedCamera:
        """See `MobileRobot.camera`."""
        return self._camera

    @property
    def T_base_camera(self) -> RigidTransform:
        """See `MobileRobot.T_base_camera`."""
        return self._T_base_camera

    @property
    def radius(self) -> float:
        """See `MobileRobot.radius`."""
        return pioneer.RADIUS

    @property
    def now(self) -> float:
        """See `MobileRobot.now`."""
        return self._physics.now

    @property
    def max_forward(self) -> float:
        """See `MobileRobot.max_forward`."""
        return pioneer.MAX_FORWARD

    @property
    def max_turn(self) -> float:
        """See `MobileRobot.max_turn`."""
        return pioneer.MAX_TURN

    def odometry(self) -> Odometry:
        """See `MobileRobot.odometry`."""
        return self._odometry

    def drive(self, velocity: Velocity) -> None:
        """See `MobileRobot.drive`; the motors need their time to get there."""
        self._wanted = velocity.clipped(self.max_forward, self.max_turn)

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`; rounded to whole ticks of 0.02 s, the rest is kept for later.

        Raises:
            InputError: The time is negative or not finite.
        """
        if not 0 <= seconds < np.inf:
            raise InputError(f"time passes forward, not by {seconds} s")
        began = time.monotonic()
        self._due += seconds
        while (self._ticks + 0.5) * TICK < self._due:
            self._physics.tick(self._wanted)
            self._ticks += 1
            if self._ticks % TICKS_PER_READING == 0:
                self._read_encoders()
        self._read_encoders()
        if self._real_time is not None:
            time.sleep(max(0.0, began + seconds / self._real_time - time.monotonic()))

    def truth(self) -> Truth:
        """Where the robot really is; for measurements only, never for the robot."""
        T_map_base = self._physics.T_map_base
        return Truth(self.now, composed(T_map_base, self._T_base_camera), T_map_base)

    def place(self, pose: PlanarPose) -> None:
        """Carry the robot to another pose, unknown to its wheels; no time passes."""
        self._physics.place(pose)

    def _read_encoders(self) -> None:
        if self.now > self._odometry.stamp:
            self._odometry = self._wheels.update(self.now, *self._physics.encoders)


def _station(physics: RobotPhysics, T_base_camera: RigidTransform) -> Station:
    """Where a robot's camera is; no method, for a robot that held itself would not be freed."""
    return Station(physics.now, composed(physics.T_map_base, T_base_camera))
