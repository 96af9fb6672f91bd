"""Physics of the robot in MuJoCo, with wheel slip."""

from __future__ import annotations

from importlib import import_module
from typing import Any, ClassVar

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry import PlanarPose
from circumspect.robot import DifferentialDrive, Velocity
from circumspect.simulation.pioneer import TIME_STEP

TICK = 0.02
"""Interval of motor commands and encoder readings [s]."""
FORWARD_RAMP, TURN_RAMP = 0.5, 3.0
"""Maximum acceleration of the motors [m/s²], [rad/s²]."""
SETTLING_TICKS = 25


class WheelSlip:
    """Random slip of each wheel, which changes with the patch of floor.

    On every `PATCH_M` metres of its travel a wheel loses a fraction drawn from an exponential
    distribution with the given mean. The lost distance has the mean `fraction` and the variance
    `fraction`² `PATCH_M` per metre.
    """

    PATCH_M: ClassVar[float] = 0.1
    """Travel on one patch of floor [m]."""
    MAX_SLIP: ClassVar[float] = 0.9
    """Maximum slip on a patch."""

    def __init__(self, fraction: float, rng: np.random.Generator | int = 0) -> None:
        """Set the slip of the floor.

        Args:
            fraction: Mean fraction of the travel that is lost; 0 for no slip.
            rng: A generator or a seed.

        Raises:
            InputError: The fraction is outside 0 … 0.5.
        """
        if not 0 <= fraction <= 0.5:
            raise InputError(f"the slip must be from 0 to 0.5, not {fraction}")
        self._fraction = fraction
        # Each wheel has its own random stream, independent of the path of the other.
        self._rngs = np.random.default_rng(rng).spawn(2)
        self._travels = [0.0, 0.0]
        self._patches = [-1, -1]
        self._slips = [0.0, 0.0]

    def slip(self, wheel: int) -> float:
        """Fraction of its travel that a wheel (0 left, 1 right) currently loses."""
        patch = int(self._travels[wheel] / self.PATCH_M)
        while self._patches[wheel] < patch:
            self._patches[wheel] += 1
            drawn = float(self._rngs[wheel].exponential(self._fraction)) if self._fraction else 0.0
            self._slips[wheel] = min(drawn, self.MAX_SLIP)
        return self._slips[wheel]

    def roll(self, wheel: int, travel: float) -> None:
        """Add travel of a wheel, in either direction [m]."""
        self._travels[wheel] += abs(travel)


class RobotPhysics:
    """A free base on two driven wheels and a caster.

    Slip acts between encoder and floor: while the encoder counts an angle a, the simulated wheel
    turns (1 - slip) a. In addition the contact itself can slip, for example when pushed.
    """

    def __init__(
        self, mjcf: str, drive: DifferentialDrive, slip: WheelSlip, start: PlanarPose
    ) -> None:
        """Put the robot down and let it settle.

        Raises:
            MissingExtraError: MuJoCo is not installed.
        """
        try:
            # The package fills its namespace at run time, which type checkers do not see.
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
        """Time since the start [s]."""
        return self._ticks * TICK

    @property
    def T_map_base(self) -> RigidTransform:
        """The pose of the base, including the tilt on bumps."""
        x, y, z, w, i, j, k = self._state.qpos[:7]
        return RigidTransform.from_components([x, y, z], Rotation.from_quat([i, j, k, w]))

    def place(self, pose: PlanarPose) -> None:
        """Set the pose of the robot, at rest; no time passes."""
        half = pose.yaw / 2
        self._state.qpos[:7] = [pose.x, pose.y, 0.0, np.cos(half), 0.0, 0.0, np.sin(half)]
        self._state.qvel[:] = 0
        self._state.ctrl[:] = 0
        self._velocity = Velocity()
        self._step(self._world, self._state, SETTLING_TICKS * round(TICK / TIME_STEP))
        self._angles = self._state.qpos[7:9].tolist()

    def tick(self, wanted: Velocity) -> None:
        """Advance by `TICK` seconds while the motors approach a velocity."""
        self._velocity = Velocity(
            _towards(self._velocity.forward, wanted.forward, FORWARD_RAMP * TICK),
            _towards(self._velocity.turn, wanted.turn, TURN_RAMP * TICK),
        )
        speeds = self._drive.wheel_speeds(self._velocity)
        traction = (1 - self._slip.slip(0), 1 - self._slip.slip(1))
        self._state.ctrl[0] = speeds[0] * traction[0]
        self._state.ctrl[1] = speeds[1] * traction[1]
        self._step(self._world, self._state, round(TICK / TIME_STEP))
        angles = self._state.qpos[7:9].tolist()
        for wheel in (0, 1):
            counted = (angles[wheel] - self._angles[wheel]) / traction[wheel]
            self.encoders[wheel] += counted
            self._slip.roll(wheel, counted * self._drive.wheel_radius)
        self._angles = angles
        self._ticks += 1


def _towards(value: float, wanted: float, max_change: float) -> float:
    return value + min(max(wanted - value, -max_change), max_change)
