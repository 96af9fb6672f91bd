"""The Pioneer 3-DX and its floor as a MuJoCo model (MJCF)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.robot import DifferentialDrive

LENGTH, WIDTH = 0.455, 0.381
"""Size of the footprint [m]."""
AXLE_AHEAD = 0.045
"""Distance of the axle in front of the footprint's centre [m]; estimated from drawings."""
RADIUS = float(np.hypot(LENGTH / 2 + AXLE_AHEAD, WIDTH / 2))
"""Radius of the circle around `base_link` that contains the footprint [m]."""
MAX_FORWARD, MAX_TURN = 1.2, float(np.radians(300))
"""Maximum speed [m/s] and turning rate [rad/s] of the Pioneer 3-DX."""
MASS = 18.0
"""Mass with batteries, laptop and mast [kg]; estimated."""
TIME_STEP = 0.004
"""Time step of the physics [s]."""
HARD = 'solimp="0.98 0.998 0.001"'
"""Contact parameters with a wheel creep of only 0.02 %."""
BUMPS_PER_AREA = 1.5
"""Ridges per square metre of an uneven floor."""
BUMP_HALF_WIDTH = 5.0
"""Half the side of the uneven square around the start [m]."""
BUMP_RADIUS = 0.06
"""Radius of the ridges [m]."""


@dataclass(frozen=True)
class RobotSettings:
    """Errors of the robot and its floor.

    Attributes:
        slip: Fraction of the wheels' travel that does not become motion; see `WheelSlip`.
        expected_slip: Slip that the odometry subtracts, from a calibration drive. With 0 the
            odometry overestimates the distance on a floor with slip.
        wheel_radius_error: Excess of the right wheel's radius over that of the left one, as a
            fraction of their mean. The odometry assumes equal wheels, so that the robot drifts to
            the left.
        bump_height: Height of the highest ridge on the floor [m]; the robot passes up to 0.02 m.

    Raises:
        InputError: A value is invalid.
    """

    slip: float = 0.0
    expected_slip: float = 0.0
    wheel_radius_error: float = 0.0
    bump_height: float = 0.0

    def __post_init__(self) -> None:
        for fraction in (self.slip, self.expected_slip):
            if not 0 <= fraction <= 0.5:
                raise InputError(f"slip is a fraction from 0 to 0.5, not {fraction}")
        if not abs(self.wheel_radius_error) <= 0.2:
            raise InputError(f"wheels differ by at most 0.2, not {self.wheel_radius_error}")
        if not 0 <= self.bump_height <= 0.05:
            raise InputError(f"bumps are from 0 to 0.05 m high, not {self.bump_height} m")


def world(
    settings: RobotSettings,
    drive: DifferentialDrive,
    boxes: NDArray[np.float64],
    height: float,
    start_xy: NDArray[np.float64],
    rng: np.random.Generator,
) -> str:
    """The MJCF of robot, floor and obstacles.

    The wheels are spheres with one contact point each; the caster is a ball without friction. The
    integrator is explicit: an implicit one applies the motors' damping after the contacts, which
    separates base and wheels by centimetres on a start. The robot collides with obstacles as a box
    of the footprint, as high as the mast.

    Args:
        settings: Errors of the wheels and height of the bumps.
        drive: Nominal wheels.
        boxes: (n, 4) [m] obstacles, see `footprint_boxes`.
        height: Height of robot and obstacles [m].
        start_xy: (2,) [m] centre of the bumps.
        rng: Source of the positions of the bumps.
    """
    left = drive.wheel_radius * (1 - settings.wheel_radius_error / 2)
    right = drive.wheel_radius * (1 + settings.wheel_radius_error / 2)
    half = drive.track / 2
    bumps = _bumps(settings.bump_height, start_xy, rng)
    return f"""
<mujoco model="pioneer">
  <option timestep="{TIME_STEP}" integrator="Euler"/>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1" contype="1" conaffinity="0" friction="0.9" {HARD}/>
    {bumps}
    {_boxes(boxes, height)}
    <body name="base">
      <freejoint/>
      <inertial pos="-0.06 0 0.15" mass="{MASS - 1}" diaginertia="0.35 0.45 0.40"/>
      <geom name="hull" type="box" contype="0" conaffinity="2" friction="0.2"
            pos="{-AXLE_AHEAD} 0 {height / 2 + 0.03}"
            size="{LENGTH / 2} {WIDTH / 2} {height / 2 - 0.03}"/>
      <geom name="caster" type="sphere" size="0.04" pos="-0.23 0 0.04" contype="0"
            conaffinity="1" condim="1" priority="1"/>
      {_wheel("left", half, left)}
      {_wheel("right", -half, right)}
    </body>
  </worldbody>
  <actuator>
    <velocity joint="left" kv="10" forcerange="-8 8"/>
    <velocity joint="right" kv="10" forcerange="-8 8"/>
  </actuator>
</mujoco>"""


def _wheel(name: str, y: float, radius: float) -> str:
    return f"""
      <body name="{name}" pos="0 {y} {radius}">
        <joint name="{name}" type="hinge" axis="0 1 0" armature="0.05"/>
        <inertial pos="0 0 0" mass="0.5" diaginertia="0.0014 0.0025 0.0014"/>
        <geom type="sphere" size="{radius}" contype="0" conaffinity="1" friction="0.9" {HARD}/>
      </body>"""


def _boxes(boxes: NDArray[np.float64], height: float) -> str:
    middles, halves = (boxes[:, :2] + boxes[:, 2:]) / 2, (boxes[:, 2:] - boxes[:, :2]) / 2
    return "\n    ".join(
        f'<geom type="box" contype="2" conaffinity="0" friction="0.2" '
        f'pos="{x:.6f} {y:.6f} {height / 2}" size="{a:.6f} {b:.6f} {height / 2}"/>'
        for (x, y), (a, b) in zip(middles, halves, strict=True)
    )


def _bumps(height: float, centre_xy: NDArray[np.float64], rng: np.random.Generator) -> str:
    """Round ridges, like cables and thresholds, up to `height` above the floor."""
    if height == 0:
        return ""
    count = int(BUMPS_PER_AREA * (2 * BUMP_HALF_WIDTH) ** 2)
    places = centre_xy + rng.uniform(-BUMP_HALF_WIDTH, BUMP_HALF_WIDTH, (count, 2))
    headings = rng.uniform(0, np.pi, count)
    rises = height * rng.uniform(0.3, 1.0, count)
    ends = 0.15 * np.column_stack([np.cos(headings), np.sin(headings)])
    shape = f'type="capsule" size="{BUMP_RADIUS}" contype="1" conaffinity="0" friction="0.9" {HARD}'
    return "\n    ".join(
        f'<geom {shape} fromto="{x - a:.5f} {y - b:.5f} {z:.5f} {x + a:.5f} {y + b:.5f} {z:.5f}"/>'
        for (x, y), (a, b), z in zip(places, ends, rises - BUMP_RADIUS, strict=True)
    )
