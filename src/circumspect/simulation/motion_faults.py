"""Robots that do not move as their wheels say.

For tests and measurements; deterministic by seed. Times are seconds of the robot's clock.
"""

from __future__ import annotations

from dataclasses import replace

from circumspect.geometry import PlanarPose
from circumspect.robot import MobileRobot, Velocity, WrappedRobot, arc
from circumspect.sensing import Odometry
from circumspect.simulation.simulated_robot import SimulatedRobot

SLICE = 0.1
"""Faults in driving begin and end with this accuracy [s]."""


class Blocked(WrappedRobot):
    """For a span of time the robot stands still, though its wheels turn as they are told."""

    def __init__(self, robot: MobileRobot, after: float, seconds: float = 5.0) -> None:
        super().__init__(robot)
        self._span = (after, after + seconds)
        self._wanted = Velocity()
        self._spun = PlanarPose()
        self._last: tuple[Odometry, Odometry] | None = None

    @property
    def _blocked(self) -> bool:
        return self._span[0] - SLICE / 2 <= self.now < self._span[1] - SLICE / 2

    def drive(self, velocity: Velocity) -> None:
        """See `MobileRobot.drive`."""
        self._wanted = velocity.clipped(self.max_forward, self.max_turn)

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        for piece in slices(seconds):
            self.robot.drive(Velocity() if self._blocked else self._wanted)
            odometry = self.robot.odometry()
            if self._blocked and odometry is not None:
                # What the wheels seem to drive is put in between what was and what comes.
                here = odometry.T_odom_base
                spun = arc(self._wanted.forward * piece, self._wanted.turn * piece)
                self._spun = self._spun @ here @ spun @ here.inverse()
            self.robot.wait(piece)

    def _told(self, odometry: Odometry | None) -> Odometry | None:
        if odometry is None:
            return None
        told = replace(odometry, T_odom_base=self._spun @ odometry.T_odom_base)
        if self._last is not None:
            # An error of the heading moves the way that the wheels seemed to drive, too.
            before, told_before = self._last
            told = told.grown_from(told_before, odometry.growth_since(before))
        self._last = odometry, told
        if not self._blocked:
            return told
        return replace(told, forward=self._wanted.forward, turn=self._wanted.turn)


class Kidnapped(WrappedRobot):
    """At one time somebody lifts the robot and puts it down elsewhere."""

    def __init__(self, robot: SimulatedRobot, after: float, by: PlanarPose) -> None:
        """Set up.

        Args:
            robot: Whom to kidnap.
            after: When.
            by: To where, seen from where it then stands (`T_before_after`).
        """
        super().__init__(robot)
        self._simulated, self._after, self._by = robot, after, by
        self._done = False

    def wait(self, seconds: float) -> None:
        """See `MobileRobot.wait`."""
        for piece in slices(seconds):
            if not self._done and self.now >= self._after - SLICE / 2:
                here = PlanarPose.from_transform(self._simulated.truth().T_map_base)
                self._simulated.place(here @ self._by)
                self._done = True
            self.robot.wait(piece)


def slices(seconds: float) -> list[float]:
    """Pieces of at most `SLICE` that make up `seconds`."""
    whole = int(seconds / SLICE)
    rest = seconds - whole * SLICE
    return [SLICE] * whole + ([rest] if rest > 1e-9 else [])
