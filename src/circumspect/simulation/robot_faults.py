"""Faults of a robot's motion, wheel odometry and clocks, for tests and measurements.

Deterministic by seed. Times are seconds of the clock of the wrapped robot.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from circumspect.geometry import PlanarPose
from circumspect.robot import MobileRobot, Velocity, WrappedRobot, arc
from circumspect.sensing import Odometry, RgbdFrame
from circumspect.simulation.simulated_robot import SimulatedRobot

TIME_STEP_S = 0.1
"""Faults in driving start and end with this accuracy [s]."""
STAMP_TOLERANCE_S = 1e-6
"""Stamps that differ by less are equal [s]."""


class Blocked(WrappedRobot):
    """For some time the robot is blocked while its wheels turn as commanded."""

    def __init__(self, robot: MobileRobot, after: float, seconds: float = 5.0) -> None:
        super().__init__(robot)
        self._span = (after, after + seconds)
        self._command = Velocity()
        self._wheel_motion = PlanarPose()
        self._last: tuple[Odometry, Odometry] | None = None

    @property
    def _blocked(self) -> bool:
        return self._span[0] - TIME_STEP_S / 2 <= self.now < self._span[1] - TIME_STEP_S / 2

    def drive(self, velocity: Velocity) -> None:
        """See `MobileRobot.drive`."""
        self._command = velocity.clipped(self.max_forward, self.max_turn)

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        for step in time_steps(seconds):
            self.robot.drive(Velocity() if self._blocked else self._command)
            odometry = self.robot.odometry()
            if self._blocked and odometry is not None:
                # Insert the apparent motion of the wheels between past and future motion.
                here = odometry.T_odom_base
                spun = arc(self._command.forward * step, self._command.turn * step)
                self._wheel_motion = self._wheel_motion @ here @ spun @ here.inverse()
            self.robot.wait(step)

    def _on_odometry(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None:
            return None
        changed = replace(odometry, T_odom_base=self._wheel_motion @ odometry.T_odom_base)
        if self._last is not None:
            # The heading error also rotates the apparent motion of the wheels.
            before, changed_before = self._last
            changed = changed.grown_from(changed_before, odometry.growth_since(before))
        self._last = odometry, changed
        if not self._blocked:
            return changed
        return replace(changed, forward=self._command.forward, turn=self._command.turn)


class Kidnapped(WrappedRobot):
    """The robot is displaced once without its odometry noticing."""

    def __init__(self, robot: SimulatedRobot, after: float, by: PlanarPose) -> None:
        """Wrap a robot.

        Args:
            robot: The robot.
            after: Time of the displacement [s].
            by: Displacement relative to its pose (`T_before_after`).
        """
        super().__init__(robot)
        self._simulated, self._after, self._by = robot, after, by
        self._done = False

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        for step in time_steps(seconds):
            if not self._done and self.now >= self._after - TIME_STEP_S / 2:
                here = PlanarPose.from_transform(self._simulated.truth().T_map_base)
                self._simulated.place(here @ self._by)
                self._done = True
            self.robot.wait(step)


def time_steps(seconds: float) -> list[float]:
    """Steps of at most `TIME_STEP_S` with the sum `seconds`."""
    whole = int(seconds / TIME_STEP_S)
    rest = seconds - whole * TIME_STEP_S
    return [TIME_STEP_S] * whole + ([rest] if rest > 1e-9 else [])


class ClockStartingAt(WrappedRobot):
    """The clock of robot, images and odometry starts at another time."""

    def __init__(self, robot: MobileRobot, start: float) -> None:
        super().__init__(robot)
        self._ahead = start - robot.now

    @property
    def now(self) -> float:
        """See `MobileRobot.now`."""
        return self.robot.now + self._ahead

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        return replace(frame, stamp=frame.stamp + self._ahead)

    def _on_odometry(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None:
            return None
        return replace(odometry, stamp=odometry.stamp + self._ahead)


class OdometryOfAnotherEpoch(WrappedRobot):
    """The stamps of odometry differ from those of images by a constant."""

    def __init__(self, robot: MobileRobot, ahead: float = 1.7e9) -> None:
        super().__init__(robot)
        self._ahead = ahead

    def _on_odometry(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None:
            return None
        return replace(odometry, stamp=odometry.stamp + self._ahead)


class OdometryLagging(WrappedRobot):
    """Frames carry the odometry of an earlier time under their own stamp.

    This happens in matching by stamps if the clock of the images is behind.
    """

    def __init__(self, robot: MobileRobot, seconds: float) -> None:
        super().__init__(robot)
        self._lag = seconds
        self._past: deque[Odometry] = deque()
        self._remember()

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        for step in time_steps(seconds):
            self.robot.wait(step)
            self._remember()

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`."""
        frame = super().observe()
        if frame.odometry is None:
            return frame
        self._remember()
        while (
            len(self._past) > 1
            and self._past[1].stamp <= frame.stamp - self._lag + STAMP_TOLERANCE_S
        ):
            self._past.popleft()
        earlier = self._past[0]
        if earlier.stamp > frame.stamp - self._lag + STAMP_TOLERANCE_S:
            return replace(frame, odometry=None)
        return replace(frame, odometry=replace(earlier, stamp=frame.stamp))

    def _remember(self) -> None:
        odometry = self.robot.odometry()
        is_new = not self._past or odometry is None or odometry.stamp > self._past[-1].stamp
        if odometry is not None and is_new:
            self._past.append(odometry)


class OdometryGone(WrappedRobot):
    """For some time there is no odometry."""

    def __init__(self, robot: MobileRobot, after: float = 0.0, seconds: float = np.inf) -> None:
        super().__init__(robot)
        self._span = (after, after + seconds)

    def _on_odometry(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None or self._span[0] <= odometry.stamp < self._span[1]:
            return None
        return odometry


class OdometryJumping(WrappedRobot):
    """From a given time on, the odometry jumps repeatedly, and the jumps accumulate."""

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

    def _on_odometry(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None or odometry.stamp < self._after:
            return odometry
        pose = odometry.T_odom_base
        for number in range(int((odometry.stamp - self._after) / self._every) + 1):
            drawn = np.random.default_rng([self._seed, number]).uniform(-1, 1, 3)
            pose = PlanarPose(*(drawn * self._sizes)) @ pose
        return replace(odometry, T_odom_base=pose)


class OdometryStuck(WrappedRobot):
    """From a given time on, the odometry reports that the robot stands still."""

    def __init__(self, robot: MobileRobot, after: float) -> None:
        super().__init__(robot)
        self._after = after
        self._last: Odometry | None = None

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        self._on_odometry(self.robot.odometry())
        super().wait(seconds)

    def _on_odometry(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None or odometry.stamp < self._after or self._last is None:
            self._last = odometry
            return odometry
        return replace(self._last, stamp=odometry.stamp, forward=0.0, turn=0.0)


class OdometryCovariance(WrappedRobot):
    """The covariance of the odometry is a constant, which may be NaN."""

    def __init__(self, robot: MobileRobot, variance: float) -> None:
        super().__init__(robot)
        self._covariance = np.diag([variance] * 3)

    def _on_odometry(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None:
            return None
        return replace(odometry, covariance=self._covariance)
