"""Writes down where a simulated robot really was."""

from __future__ import annotations

from collections.abc import Callable

from circumspect.errors import InputError
from circumspect.geometry import Trajectory, TrajectoryLog
from circumspect.robot import WrappedRobot
from circumspect.sensing import RgbdFrame
from circumspect.simulation.simulated_robot import SimulatedRobot, Truth


class Witness(WrappedRobot):
    """A robot without fault whose true poses are kept; for measurements only.

    It belongs directly round the simulated robot, inside of any faults, so that it sees each
    frame with its true time.

    Attributes:
        simulated: The robot inside.
        others: Told the truth at each frame, as ceiling cameras see it.
    """

    def __init__(self, robot: SimulatedRobot) -> None:
        super().__init__(robot)
        self.simulated = robot
        self.others: tuple[Callable[[Truth], None], ...] = ()
        self._log = TrajectoryLog()

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        if self._log.is_news(frame.stamp):
            truth = self.simulated.truth()
            self._log.add(frame.stamp, truth.T_map_camera)
            for other in self.others:
                other(truth)
        return frame

    @property
    def trajectory(self) -> Trajectory:
        """Where the camera really was at each frame so far, in the scene's frame.

        Raises:
            InputError: No frame was taken yet.
        """
        if (trajectory := self._log.trajectory) is None:
            raise InputError("no frame was taken yet; there is no true trajectory")
        return trajectory
