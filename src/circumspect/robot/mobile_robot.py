"""The interface of every robot that carries a camera: real, replayed or simulated."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace

from scipy.spatial.transform import RigidTransform

from circumspect.robot.velocity import Velocity
from circumspect.sensing import Odometry, RgbdCamera, RgbdFrame


class MobileRobot(ABC):
    """Drives on a floor, says what its wheels did, and carries one RGB-D camera.

    What it tells is what a real robot can know: where it really is stays hidden.
    """

    @property
    @abstractmethod
    def camera(self) -> RgbdCamera:
        """The camera it carries."""

    @property
    @abstractmethod
    def T_base_camera(self) -> RigidTransform:
        """Where the camera is mounted (optical frame), by the robot's drawings."""

    @property
    @abstractmethod
    def radius(self) -> float:
        """Of the circle round `base_link` that holds the footprint [m]."""

    @property
    @abstractmethod
    def now(self) -> float:
        """Time [s]."""

    @property
    def held(self) -> float:
        """How much of that time somebody made it stand, who is no obstacle [s]."""
        return 0.0

    @property
    @abstractmethod
    def max_forward(self) -> float:
        """The largest speed that `drive` takes [m/s]."""

    @property
    @abstractmethod
    def max_turn(self) -> float:
        """The largest turning rate that `drive` takes [rad/s]."""

    @abstractmethod
    def odometry(self) -> Odometry | None:
        """What the wheels say now; None where they say nothing."""

    @abstractmethod
    def drive(self, velocity: Velocity) -> None:
        """Set the velocity to keep from now on; what is too fast is slowed down."""

    @abstractmethod
    def wait(self, seconds: float) -> None:
        """Let time pass [s], driving on as told."""

    def stop(self) -> None:
        """Stand still."""
        self.drive(Velocity())

    def observe(self) -> RgbdFrame:
        """Take a frame that carries the odometry of its time and the camera's mounting."""
        frame = self.camera.capture()
        return replace(frame, odometry=self.odometry(), T_base_camera=self.T_base_camera)
