"""A robot around another one: to record it, to watch it, to make it fail.

What derives from it acts on `observe` and `odometry`, not on `camera`; wrappers can be combined.
"""

from __future__ import annotations

from dataclasses import replace

from scipy.spatial.transform import RigidTransform

from circumspect.robot.mobile_robot import MobileRobot
from circumspect.robot.velocity import Velocity
from circumspect.sensing import Odometry, RgbdCamera, RgbdFrame


class WrappedRobot(MobileRobot):
    """A robot that passes everything on; see `MobileRobot`."""

    def __init__(self, robot: MobileRobot) -> None:
        self.robot = robot

    @property
    def camera(self) -> RgbdCamera:
        """The camera itself, past the wrapper."""
        return self.robot.camera

    @property
    def T_base_camera(self) -> RigidTransform:
        """See `MobileRobot.T_base_camera`."""
        return self.robot.T_base_camera

    @property
    def radius(self) -> float:
        """See `MobileRobot.radius`."""
        return self.robot.radius

    @property
    def now(self) -> float:
        """See `MobileRobot.now`."""
        return self.robot.now

    @property
    def held(self) -> float:
        """See `MobileRobot.held`."""
        return self.robot.held

    @property
    def max_forward(self) -> float:
        """See `MobileRobot.max_forward`."""
        return self.robot.max_forward

    @property
    def max_turn(self) -> float:
        """See `MobileRobot.max_turn`."""
        return self.robot.max_turn

    def drive(self, velocity: Velocity) -> None:
        """See `MobileRobot.drive`."""
        self.robot.drive(velocity)

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        self.robot.wait(seconds)

    def odometry(self) -> Odometry | None:
        """See `MobileRobot.odometry`."""
        return self._told(self.robot.odometry())

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`."""
        frame = self._seen(self.robot.observe())
        told = self._told(frame.odometry)
        return frame if told is frame.odometry else replace(frame, odometry=told)

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        """What becomes of a frame."""
        return frame

    def _told(self, odometry: Odometry | None) -> Odometry | None:
        """What becomes of the odometry; asked several times for one instant."""
        return odometry
