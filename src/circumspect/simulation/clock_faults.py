"""Robots whose clocks start anywhere, or whose images and odometry have different clocks.

For tests and measurements. Times are seconds of the inner robot's clock.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import Odometry, RgbdFrame
from circumspect.simulation.motion_faults import slices

TOLERANCE = 1e-6
"""Stamps that differ by less are equal [s]."""


class ClockStartingAt(WrappedRobot):
    """The clock of robot, images and odometry starts at another time."""

    def __init__(self, robot: MobileRobot, start: float) -> None:
        super().__init__(robot)
        self._ahead = start - robot.now

    @property
    def now(self) -> float:
        """See `MobileRobot.now`."""
        return self.robot.now + self._ahead

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        return replace(frame, stamp=frame.stamp + self._ahead)

    def _told(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None:
            return None
        return replace(odometry, stamp=odometry.stamp + self._ahead)


class OdometryOfAnotherEpoch(WrappedRobot):
    """The stamps of odometry differ from those of images by a constant."""

    def __init__(self, robot: MobileRobot, ahead: float = 1.7e9) -> None:
        super().__init__(robot)
        self._ahead = ahead

    def _told(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None:
            return None
        return replace(odometry, stamp=odometry.stamp + self._ahead)


class OdometryLagging(WrappedRobot):
    """Frames bring the odometry of an earlier time under their own stamp.

    That is what matching by stamps gives if the clock of the images is behind.
    """

    def __init__(self, robot: MobileRobot, seconds: float) -> None:
        super().__init__(robot)
        self._lag = seconds
        self._past: deque[Odometry] = deque()
        self._remember()

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        for piece in slices(seconds):
            self.robot.wait(piece)
            self._remember()

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`."""
        frame = super().observe()
        if frame.odometry is None:
            return frame
        self._remember()
        while len(self._past) > 1 and self._past[1].stamp <= frame.stamp - self._lag + TOLERANCE:
            self._past.popleft()
        earlier = self._past[0]
        if earlier.stamp > frame.stamp - self._lag + TOLERANCE:
            return replace(frame, odometry=None)
        return replace(frame, odometry=replace(earlier, stamp=frame.stamp))

    def _remember(self) -> None:
        odometry = self.robot.odometry()
        is_new = not self._past or odometry is None or odometry.stamp > self._past[-1].stamp
        if odometry is not None and is_new:
            self._past.append(odometry)
