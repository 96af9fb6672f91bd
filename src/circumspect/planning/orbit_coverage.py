"""Coverage of the orbit round the object by the robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.geometry import PlanarPose, wrapped
from circumspect.planning.base_pose import camera_place
from circumspect.planning.planner_input import PlannerInput

SECTORS = 72
SECTOR_RAD = 2 * np.pi / SECTORS
VISITED_HALF_WIDTH_RAD = float(np.radians(8.0))
"""Maximum angle between a direction and the robot for the direction to count as visited [rad]."""
UNREACHABLE_HALF_WIDTH_RAD = float(np.radians(25.0))
"""Angle around an unreachable view that counts as unreachable [rad]."""


def bearing_turned(planner_input: PlannerInput) -> float:
    """Net angle that the robot has moved round the object, counter-clockwise [degrees]."""
    if len(planner_input.visited) < 2 or len(planner_input.points_xyz) == 0:
        return 0.0
    centre = planner_input.centre_xy
    places = np.array([pose.xy for pose in planner_input.visited])
    bearings = np.unwrap(bearings_of(places, centre))
    return float(np.degrees(bearings[-1] - bearings[0]))


def sectors_visited(planner_input: PlannerInput) -> NDArray[np.bool_]:
    """(72,) the directions from the object in which the robot has been."""
    return _near(planner_input, planner_input.visited, VISITED_HALF_WIDTH_RAD)


def is_orbit_covered(planner_input: PlannerInput) -> bool:
    """Whether the robot visited all directions that are not near unreachable views."""
    missing = unreachable_bases(planner_input)
    there = sectors_visited(planner_input) | _near(
        planner_input, missing, UNREACHABLE_HALF_WIDTH_RAD
    )
    return bool(missing) and bool(there.all())


def unreachable_bases(planner_input: PlannerInput) -> list[PlanarPose]:
    """`T_map_base` of the unreachable views whose direction was not visited later."""
    if not planner_input.given_up:
        return []
    visited = sectors_visited(planner_input)
    bases = [view.T_map_base for view in planner_input.given_up]
    return [base for base in bases if not visited[_sector_of(planner_input, base)]]


def _sector_of(planner_input: PlannerInput, base: PlanarPose) -> int:
    bearing = float(bearings_of([base.xy], planner_input.centre_xy)[0])
    return int(bearing % (2 * np.pi) / SECTOR_RAD) % SECTORS


def next_turn(planner_input: PlannerInput, step: float) -> float | None:
    """Angle to the next direction that was neither visited nor found unreachable.

    Args:
        planner_input: Input with the unreachable views.
        step: Angle between tested directions [rad].

    Returns:
        Angle counter-clockwise from the camera [rad]; None if all directions were tried.
    """
    bearing = camera_bearing(planner_input, planner_input.T_map_base)
    mounting = planner_input.T_base_camera
    refused = [camera_place(view.T_map_base, mounting) for view in planner_input.unreachable]
    visited = [camera_place(pose, mounting) for pose in planner_input.visited]
    tried = _near(planner_input, visited, VISITED_HALF_WIDTH_RAD) | _near(
        planner_input, refused, UNREACHABLE_HALF_WIDTH_RAD
    )
    for turn in np.arange(step, 2 * np.pi, step):
        if not tried[int((bearing + turn) % (2 * np.pi) / SECTOR_RAD) % SECTORS]:
            return float(turn)
    return None


def _near(
    planner_input: PlannerInput, poses: Sequence[PlanarPose], within: float
) -> NDArray[np.bool_]:
    """(72,) the sectors whose centre is within an angle [rad] of the direction of a pose."""
    if len(poses) == 0 or len(planner_input.points_xyz) == 0:
        return np.zeros(SECTORS, bool)
    places = np.array([pose.xy for pose in poses])
    bearings = bearings_of(places, planner_input.centre_xy)
    apart = (np.arange(SECTORS) + 0.5)[:, None] * SECTOR_RAD - bearings[None, :]
    return np.any(np.abs(wrapped(apart)) <= within, axis=1)


def camera_bearing(planner_input: PlannerInput, T_map_base: PlanarPose) -> float:
    """Direction from the object's centre to the camera of a robot at a pose [rad]."""
    camera = camera_place(T_map_base, planner_input.T_base_camera)
    return float(bearings_of([camera.xy], planner_input.centre_xy)[0])


def bearings_of(places_xy: ArrayLike, centre_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) directions from the centre to (n, 2) positions [rad]."""
    offset = np.asarray(places_xy, float) - centre_xy
    return np.arctan2(offset[:, 1], offset[:, 0])
