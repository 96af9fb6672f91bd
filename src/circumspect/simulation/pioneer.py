"""The Pioneer 3-DX and its floor, in MuJoCo's words (MJCF)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.robot import DifferentialDrive

if TYPE_CHECKING:
    from circumspect.simulation.simulated_robot import RobotSettings

LENGTH, WIDTH = 0.455, 0.381
"""Of the footprint [m]."""
AXLE_AHEAD = 0.045
"""How far the axle lies before the middle of the footprint [m]; ours, by the robot's drawings."""
RADIUS = float(np.hypot(LENGTH / 2 + AXLE_AHEAD, WIDTH / 2))
"""Of the circle round `base_link` that holds the footprint [m]."""
MAX_FORWARD, MAX_TURN = 1.2, float(np.radians(300))
"""Of the Pioneer 3-DX [m/s], [rad/s]."""
MASS = 18.0
"""With batteries, laptop and mast [kg]; ours."""
TIME_STEP = 0.004
"""Of the physics [s]."""
HARD = 'solimp="0.98 0.998 0.001"'
"""Contacts this hard let wheels creep by 0.02 % only."""
BUMPS_PER_AREA = 1.5
"""Ridges on each square metre of an uneven floor."""
BUMP_HALF_WIDTH = 5.0
"""The floor is uneven this far around the start [m]."""
BUMP_RADIUS = 0.06
"""Of the ridges' round back [m]."""


def world(
    settings: RobotSettings,
    drive: DifferentialDrive,
    boxes: NDArray[np.float64],
    height: float,
    start_xy: NDArray[np.float64],
    rng: np.random.Generator,
) -> str:
    """The whole world as MJCF.

    The wheels touch the floor in one point each, as spheres do; the caster is a ball without
    friction. The integrator is the explicit one: an implicit one takes the motors' damping into
    account after the contacts, and then base and wheels part by centimetres on a start.
    Everything above the floor meets the footprint as a box as high as the mast.

    Args:
        settings: Of the robot; gives the error of the wheels and the height of the bumps.
        drive: The wheels as the drawings have them.
        boxes: (n, 4) [m] obstacles, see `footprint_boxes`.
        height: Of robot and obstacles [m].
        start_xy: (2,) [m] the middle of the bumps.
        rng: Places the bumps.
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
    """Round ridges, as of cables and thresholds, that rise up to `height` out of the floor."""
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
