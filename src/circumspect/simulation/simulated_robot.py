"""A simulated Pioneer 3-DX, and the recorder of its true poses."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera, PlanarPose, Trajectory, TrajectoryLog
from circumspect.geometry.composition import composed
from circumspect.robot import DifferentialDrive, MobileRobot, Velocity, WheelOdometry, WrappedRobot
from circumspect.sensing import DepthNoise, Odometry, RgbdFrame
from circumspect.simulation import pioneer
from circumspect.simulation.orbit import CameraMount
from circumspect.simulation.pioneer import RobotSettings
from circumspect.simulation.robot_physics import TICK, RobotPhysics, WheelSlip
from circumspect.simulation.scene import Scene, footprint_boxes
from circumspect.simulation.simulated_camera import DepthDistortion, SimulatedCamera
from circumspect.simulation.station import Station

TICKS_PER_READING = 5
"""Ticks per reading of the encoders: ten readings a second, as on the real robot."""


class GroundTruthRecorder(WrappedRobot):
    """Records the true poses of a simulated robot; for measurements only.

    It wraps the simulated robot directly, inside any faults, so that stamps of frames are true.

    Attributes:
        simulated: The simulated robot.
        observers: Called with the true state at each frame.
    """

    def __init__(self, robot: SimulatedRobot) -> None:
        super().__init__(robot)
        self.simulated = robot
        self.observers: tuple[Callable[[TrueState], None], ...] = ()
        self._log = TrajectoryLog()

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        if self._log.is_later(frame.stamp):
            truth = self.simulated.truth()
            self._log.add(frame.stamp, truth.T_map_camera)
            for other in self.observers:
                other(truth)
        return frame

    @property
    def trajectory(self) -> Trajectory:
        """True trajectory of the camera, in the frame of the scene.

        Raises:
            InputError: No frame was taken yet.
        """
        if (trajectory := self._log.trajectory) is None:
            raise InputError("no frame was taken yet; the true trajectory is empty")
        return trajectory


@dataclass(frozen=True)
class TrueState:
    """True state of the robot; for measurements only.

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
        """Place a robot in a scene.

        Args:
            scene: Scene with its obstacles.
            start: Initial pose, map frame.
            mount: Mount of the camera.
            settings: Slip, wheels and floor.
            intrinsics: Intrinsics of the camera; None for the Xtion PRO.
            noise: Depth noise; None for exact depth.
            seed: Seed of all random numbers.
            colour: Whether to render shaded colour images.
            real_time: Maximum simulated seconds per second; None for no limit.
            distortion: Depth distortion; None for none.

        Raises:
            InputError: `real_time` is not positive, or the distortion is that of another image
                size.
            MissingExtraError: Embree or MuJoCo is not installed.
        """
        if real_time is not None and not 0 < real_time < np.inf:
            raise InputError(f"real_time must be positive, not {real_time}")
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
        self._command = Velocity()
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
        """See `MobileRobot.drive`; the motors accelerate gradually."""
        self._command = velocity.clipped(self.max_forward, self.max_turn)

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`; in whole ticks of 0.02 s, the remainder is added to later calls.

        Raises:
            InputError: The time is negative or not finite.
        """
        if not 0 <= seconds < np.inf:
            raise InputError(f"time passes forward, not by {seconds} s")
        began = time.monotonic()
        self._due += seconds
        while (self._ticks + 0.5) * TICK < self._due:
            self._physics.tick(self._command)
            self._ticks += 1
            if self._ticks % TICKS_PER_READING == 0:
                self._read_encoders()
        self._read_encoders()
        if self._real_time is not None:
            time.sleep(max(0.0, began + seconds / self._real_time - time.monotonic()))

    def truth(self) -> TrueState:
        """The true state; for measurements only, not for the robot."""
        T_map_base = self._physics.T_map_base
        return TrueState(self.now, composed(T_map_base, self._T_base_camera), T_map_base)

    def place(self, pose: PlanarPose) -> None:
        """Move the robot to another pose without its odometry noticing; no time passes."""
        self._physics.place(pose)

    def _read_encoders(self) -> None:
        if self.now > self._odometry.stamp:
            self._odometry = self._wheels.update(self.now, *self._physics.encoders)


def _station(physics: RobotPhysics, T_base_camera: RigidTransform) -> Station:
    """Station of the robot's camera; no method, because a reference cycle would delay freeing."""
    return Station(physics.now, composed(physics.T_map_base, T_base_camera))
