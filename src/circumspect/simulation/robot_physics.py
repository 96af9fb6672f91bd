"""The moving robot in MuJoCo."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import MissingExtraError
from circumspect.geometry import PlanarPose
from circumspect.robot import DifferentialDrive, Velocity
from circumspect.simulation.pioneer import TIME_STEP
from circumspect.simulation.wheel_slip import WheelSlip

TICK = 0.02
"""The motors take commands and the encoders are read this often [s]."""
FORWARD_RAMP, TURN_RAMP = 0.5, 3.0
"""The motors change speed at most this quickly [m/s²], [rad/s²]."""
SETTLING_TICKS = 25


class RobotPhysics:
    """A free base on two driven wheels and a caster.

    Slip lies between encoder and floor: while the encoder counts an angle a, the wheel of the
    physics turns (1 - lost) a. On top of it the contact itself can slip, as when pushed.
    """

    def __init__(
        self, mjcf: str, drive: DifferentialDrive, slip: WheelSlip, start: PlanarPose
    ) -> None:
        """Put the robot down and let it settle.

        Raises:
            MissingExtraError: MuJoCo is not installed.
        """
        try:
            # The package fills its own namespace at run time, unseen by type checkers.
            mujoco: Any = import_module("mujoco")
        except ImportError as error:
            raise MissingExtraError("mujoco-core", "sim") from error
        self._step = mujoco.mj_step
        self._world = mujoco.MjModel.from_xml_string(mjcf)
        self._state = mujoco.MjData(self._world)
        self._drive = drive
        self._slip = slip
        self._velocity = Velocity()
        self._ticks = 0
        self.encoders = [0.0, 0.0]
        self.place(start)

    @property
    def now(self) -> float:
        """Time since the robot was put down first [s]."""
        return self._ticks * TICK

    @property
    def T_map_base(self) -> RigidTransform:
        """The pose in space, with the tilt that bumps give it."""
        x, y, z, w, i, j, k = self._state.qpos[:7]
        return RigidTransform.from_components([x, y, z], Rotation.from_quat([i, j, k, w]))

    def place(self, pose: PlanarPose) -> None:
        """Lift the robot and put it down elsewhere, standing still; no time passes."""
        half = pose.yaw / 2
        self._state.qpos[:7] = [pose.x, pose.y, 0.0, np.cos(half), 0.0, 0.0, np.sin(half)]
        self._state.qvel[:] = 0
        self._state.ctrl[:] = 0
        self._velocity = Velocity()
        self._step(self._world, self._state, SETTLING_TICKS * round(TICK / TIME_STEP))
        self._angles = self._state.qpos[7:9].tolist()

    def tick(self, wanted: Velocity) -> None:
        """Let `TICK` seconds pass while the motors make for a velocity."""
        self._velocity = Velocity(
            _towards(self._velocity.forward, wanted.forward, FORWARD_RAMP * TICK),
            _towards(self._velocity.turn, wanted.turn, TURN_RAMP * TICK),
        )
        speeds = self._drive.wheel_speeds(self._velocity)
        grips = (1 - self._slip.lost(0), 1 - self._slip.lost(1))
        self._state.ctrl[0] = speeds[0] * grips[0]
        self._state.ctrl[1] = speeds[1] * grips[1]
        self._step(self._world, self._state, round(TICK / TIME_STEP))
        angles = self._state.qpos[7:9].tolist()
        for wheel in (0, 1):
            counted = (angles[wheel] - self._angles[wheel]) / grips[wheel]
            self.encoders[wheel] += counted
            self._slip.roll(wheel, counted * self._drive.wheel_radius)
        self._angles = angles
        self._ticks += 1


def _towards(value: float, wanted: float, most: float) -> float:
    return value + min(max(wanted - value, -most), most)
