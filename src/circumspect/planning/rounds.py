"""How far round the object the robot has come."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.geometry import PlanarPose
from circumspect.planning.plan_view import centre_of
from circumspect.planning.situation import Situation

SECTORS = 72
SECTOR = 2 * np.pi / SECTORS
WIDTH = float(np.radians(8.0))
"""The robot was in a direction when it was within this angle of it [rad]."""
BESIDE = float(np.radians(25.0))
"""A view that was given up stands for all within this angle of it [rad]."""
BEHIND = float(np.radians(15.0))
"""A view less than this behind the robot is behind it, not ahead round the object [rad]."""


def bearing_turned(situation: Situation) -> float:
    """Degrees that the robot has gone round the object, counter-clockwise.

    What it went forth and back counts nothing.
    """
    if len(situation.visited) < 2 or len(situation.points_xyz) == 0:
        return 0.0
    centre = centre_of(situation.points_xyz)
    places = np.array([pose.xy for pose in situation.visited])
    bearings = np.unwrap(bearings_of(places, centre))
    return float(np.degrees(bearings[-1] - bearings[0]))


def sectors_visited(situation: Situation) -> NDArray[np.bool_]:
    """(72,) the directions from the object in which the robot has been."""
    return _near(situation, situation.visited, WIDTH)


def all_tried(situation: Situation) -> bool:
    """Whether the robot was, or tried in vain to be, on every side of the object."""
    given_up = [view.T_map_base for view in situation.given_up]
    return bool((sectors_visited(situation) | _near(situation, given_up, BESIDE)).all())


def next_turn(situation: Situation, step: float) -> float | None:
    """How far on the next side is where the robot was not yet, beyond the views just tried.

    Args:
        situation: With views that could not be reached.
        step: From one side to the next [rad].

    Returns:
        Angle [rad] counter-clockwise from the robot; None where it was everywhere.
    """
    centre = centre_of(situation.points_xyz)
    here = situation.T_map_base
    turns = [ahead(here, view.T_map_base, centre) for view in situation.unreachable]
    # What is a little behind is not almost once round.
    furthest = max((turn for turn in turns if turn < 2 * np.pi - BEHIND), default=0.0)
    bearing = float(bearings_of([here.xy], centre)[0])
    visited = sectors_visited(situation)
    for turn in np.arange(furthest + step, 2 * np.pi - BEHIND, step):
        if not visited[int((bearing + turn) / SECTOR) % SECTORS]:
            return float(turn)
    return None


def _near(situation: Situation, poses: Sequence[PlanarPose], within: float) -> NDArray[np.bool_]:
    """(72,) the sectors whose middle is within some angle [rad] of the direction of a pose."""
    if len(poses) == 0 or len(situation.points_xyz) == 0:
        return np.zeros(SECTORS, bool)
    places = np.array([pose.xy for pose in poses])
    bearings = bearings_of(places, centre_of(situation.points_xyz))
    apart = (np.arange(SECTORS) + 0.5)[:, None] * SECTOR - bearings[None, :]
    return np.any(np.abs((apart + np.pi) % (2 * np.pi) - np.pi) <= within, axis=1)


def bearings_of(places_xy: ArrayLike, centre_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) [rad] directions from the centre to (n, 2) places."""
    offset = np.asarray(places_xy, float) - centre_xy
    return np.arctan2(offset[:, 1], offset[:, 0])


def ahead(pose: PlanarPose, other: PlanarPose, centre_xy: NDArray[np.float64]) -> float:
    """Angle [rad] by which `other` is further round than `pose`, in [0, 2π)."""
    first, second = bearings_of([pose.xy, other.xy], centre_xy)
    return float(np.mod(second - first, 2 * np.pi))
