"""Base class of wrappers that record, observe or disturb a robot.

Subclasses change the results of `observe` and `odometry`, not of `camera`; they can be nested.
"""

from __future__ import annotations

from dataclasses import replace

from scipy.spatial.transform import RigidTransform

from circumspect.robot.mobile_robot import MobileRobot, Velocity
from circumspect.sensing import Odometry, RgbdCamera, RgbdFrame


class WrappedRobot(MobileRobot):
    """Passes all calls to a robot; see `MobileRobot`."""

    def __init__(self, robot: MobileRobot) -> None:
        self.robot = robot

    @property
    def camera(self) -> RgbdCamera:
        """The camera itself, not affected by the wrapper."""
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
    def paused_seconds(self) -> float:
        """See `MobileRobot.paused_seconds`."""
        return self.robot.paused_seconds

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
        return self._on_odometry(self.robot.odometry())

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`."""
        frame = self._on_frame(self.robot.observe())
        changed = self._on_odometry(frame.odometry)
        return frame if changed is frame.odometry else replace(frame, odometry=changed)

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        """Change a frame."""
        return frame

    def _on_odometry(self, odometry: Odometry | None) -> Odometry | None:
        """Change an odometry reading; may be called several times for one instant."""
        return odometry
