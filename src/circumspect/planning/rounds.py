"""How far round the object the robot has come."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.geometry import PlanarPose, wrapped
from circumspect.planning.situation import Situation
from circumspect.planning.stance import camera_place

SECTORS = 72
SECTOR = 2 * np.pi / SECTORS
WIDTH = float(np.radians(8.0))
"""The robot was in a direction when it was within this angle of it [rad]."""
BESIDE = float(np.radians(25.0))
"""A view that could not be reached stands for all within this angle of it [rad]."""


def bearing_turned(situation: Situation) -> float:
    """Degrees that the robot has gone round the object, counter-clockwise.

    What it went forth and back counts nothing.
    """
    if len(situation.visited) < 2 or len(situation.points_xyz) == 0:
        return 0.0
    centre = situation.centre_xy
    places = np.array([pose.xy for pose in situation.visited])
    bearings = np.unwrap(bearings_of(places, centre))
    return float(np.degrees(bearings[-1] - bearings[0]))


def sectors_visited(situation: Situation) -> NDArray[np.bool_]:
    """(72,) the directions from the object in which the robot has been."""
    return _near(situation, situation.visited, WIDTH)


def all_tried(situation: Situation) -> bool:
    """Whether the robot was on every side of the object but for some that it could not reach."""
    missing = left_out(situation)
    there = sectors_visited(situation) | _near(situation, missing, BESIDE)
    return bool(missing) and bool(there.all())


def left_out(situation: Situation) -> list[PlanarPose]:
    """`T_map_base` of the views that could not be reached, nor were passed later."""
    if not situation.given_up:
        return []
    visited = sectors_visited(situation)
    bases = [view.T_map_base for view in situation.given_up]
    return [base for base in bases if not visited[_sector_of(situation, base)]]


def _sector_of(situation: Situation, base: PlanarPose) -> int:
    bearing = float(bearings_of([base.xy], situation.centre_xy)[0])
    return int(bearing % (2 * np.pi) / SECTOR) % SECTORS


def next_turn(situation: Situation, step: float) -> float | None:
    """How far on the next side is where the robot was not yet, and did not just try to be.

    Args:
        situation: With views that could not be reached.
        step: From one side to the next [rad].

    Returns:
        Angle [rad] counter-clockwise from the camera; None where it was everywhere.
    """
    bearing = camera_bearing(situation, situation.T_map_base)
    mounting = situation.T_base_camera
    refused = [camera_place(view.T_map_base, mounting) for view in situation.unreachable]
    visited = [camera_place(pose, mounting) for pose in situation.visited]
    tried = _near(situation, visited, WIDTH) | _near(situation, refused, BESIDE)
    for turn in np.arange(step, 2 * np.pi, step):
        if not tried[int((bearing + turn) % (2 * np.pi) / SECTOR) % SECTORS]:
            return float(turn)
    return None


def _near(situation: Situation, poses: Sequence[PlanarPose], within: float) -> NDArray[np.bool_]:
    """(72,) the sectors whose middle is within some angle [rad] of the direction of a pose."""
    if len(poses) == 0 or len(situation.points_xyz) == 0:
        return np.zeros(SECTORS, bool)
    places = np.array([pose.xy for pose in poses])
    bearings = bearings_of(places, situation.centre_xy)
    apart = (np.arange(SECTORS) + 0.5)[:, None] * SECTOR - bearings[None, :]
    return np.any(np.abs(wrapped(apart)) <= within, axis=1)


def camera_bearing(situation: Situation, T_map_base: PlanarPose) -> float:
    """Direction from the object's centre to the camera of a robot that stands somewhere [rad]."""
    camera = camera_place(T_map_base, situation.T_base_camera)
    return float(bearings_of([camera.xy], situation.centre_xy)[0])


def bearings_of(places_xy: ArrayLike, centre_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) [rad] directions from the centre to (n, 2) places."""
    offset = np.asarray(places_xy, float) - centre_xy
    return np.arctan2(offset[:, 1], offset[:, 0])
