"""Faults of a robot's wheel odometry.

For tests and measurements; deterministic by seed. Times are seconds of the robot's clock.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from circumspect.geometry import PlanarPose
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import Odometry


class OdometryGone(WrappedRobot):
    """For a span of time the wheels say nothing."""

    def __init__(self, robot: MobileRobot, after: float = 0.0, seconds: float = np.inf) -> None:
        super().__init__(robot)
        self._span = (after, after + seconds)

    def _told(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None or self._span[0] <= odometry.stamp < self._span[1]:
            return None
        return odometry


class OdometryJumping(WrappedRobot):
    """From a time on the odometry jumps again and again, and stays where it jumped to."""

    def __init__(
        self,
        robot: MobileRobot,
        after: float,
        every: float = 10.0,
        metres: float = 0.3,
        radians: float = 0.5,
        seed: int = 0,
    ) -> None:
        super().__init__(robot)
        self._after, self._every = after, every
        self._sizes = np.array([metres, metres, radians])
        self._seed = seed

    def _told(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None or odometry.stamp < self._after:
            return odometry
        pose = odometry.T_odom_base
        for number in range(int((odometry.stamp - self._after) / self._every) + 1):
            drawn = np.random.default_rng([self._seed, number]).uniform(-1, 1, 3)
            pose = PlanarPose(*(drawn * self._sizes)) @ pose
        return replace(odometry, T_odom_base=pose)


class OdometryStuck(WrappedRobot):
    """From a time on the odometry says that the robot stands still."""

    def __init__(self, robot: MobileRobot, after: float) -> None:
        super().__init__(robot)
        self._after = after
        self._last: Odometry | None = None

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        self._told(self.robot.odometry())
        super().wait(seconds)

    def _told(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None or odometry.stamp < self._after or self._last is None:
            self._last = odometry
            return odometry
        return replace(self._last, stamp=odometry.stamp, forward=0.0, turn=0.0)


class OdometryCovariance(WrappedRobot):
    """The covariance of the odometry is a constant, which may be NaN."""

    def __init__(self, robot: MobileRobot, variance: float) -> None:
        super().__init__(robot)
        self._covariance = np.diag([variance] * 3)

    def _told(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None:
            return None
        return replace(odometry, covariance=self._covariance)
