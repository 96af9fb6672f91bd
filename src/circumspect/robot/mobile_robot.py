"""Base class of robots with a camera, and their velocity."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.sensing import Odometry, RgbdCamera, RgbdFrame


@dataclass(frozen=True)
class Velocity:
    """Forward speed and turning rate of `base_link`.

    Attributes:
        forward: Speed [m/s]; negative is backward.
        turn: Turning rate [rad/s], counter-clockwise seen from above.

    Raises:
        InputError: A value is not finite.
    """

    forward: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        if not np.isfinite([self.forward, self.turn]).all():
            raise InputError(f"a velocity must be finite, not {self.forward}, {self.turn}")

    def clipped(self, max_forward: float, max_turn: float) -> Velocity:
        """The velocity within limits; its arc is kept.

        Args:
            max_forward: Maximum speed in both directions [m/s].
            max_turn: Maximum turning rate in both directions [rad/s].
        """
        excess = max(abs(self.forward) / max_forward, abs(self.turn) / max_turn, 1.0)
        return Velocity(self.forward / excess, self.turn / excess)


class MobileRobot(ABC):
    """A robot on a floor with wheel odometry and one RGB-D camera.

    Its interface is that of a real robot; it does not provide the true pose.
    """

    @property
    @abstractmethod
    def camera(self) -> RgbdCamera:
        """The camera."""

    @property
    @abstractmethod
    def T_base_camera(self) -> RigidTransform:
        """Mount of the camera (optical frame), from the robot's drawings."""

    @property
    @abstractmethod
    def radius(self) -> float:
        """Radius of the footprint around `base_link` [m]."""

    @property
    @abstractmethod
    def now(self) -> float:
        """Time [s]."""

    @property
    def paused_seconds(self) -> float:
        """Total time for which an operator paused the robot [s]."""
        return 0.0

    @property
    @abstractmethod
    def max_forward(self) -> float:
        """Maximum speed of `drive` [m/s]."""

    @property
    @abstractmethod
    def max_turn(self) -> float:
        """Maximum turning rate of `drive` [rad/s]."""

    @abstractmethod
    def odometry(self) -> Odometry | None:
        """Current wheel odometry; None if unavailable."""

    @abstractmethod
    def drive(self, velocity: Velocity) -> None:
        """Set the velocity, clipped to the limits."""

    @abstractmethod
    def wait(self, seconds: float) -> None:
        """Let time pass at the commanded velocity [s]."""

    def stop(self) -> None:
        """Set the velocity to zero."""
        self.drive(Velocity())

    def observe(self) -> RgbdFrame:
        """Take a frame with the odometry of its time and the mount of the camera."""
        frame = self.camera.capture()
        return replace(frame, odometry=self.odometry(), T_base_camera=self.T_base_camera)
