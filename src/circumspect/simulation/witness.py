"""Writes down where a simulated robot really was."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import Trajectory
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
        self._stamps: list[float] = []
        self._poses: list[RigidTransform] = []

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        if not self._stamps or frame.stamp > self._stamps[-1]:
            truth = self.simulated.truth()
            self._stamps.append(frame.stamp)
            self._poses.append(truth.T_map_camera)
            for other in self.others:
                other(truth)
        return frame

    @property
    def trajectory(self) -> Trajectory:
        """Where the camera really was at each frame so far, in the scene's frame.

        Raises:
            InputError: No frame was taken yet.
        """
        if not self._stamps:
            raise InputError("no frame was taken yet; there is no true trajectory")
        return Trajectory(np.array(self._stamps), RigidTransform.concatenate(self._poses))
