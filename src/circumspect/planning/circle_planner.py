"""Views on a circle around the known part of the object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.errors import InputError
from circumspect.planning.base_pose import SURFACE_DISTANCE_M, base_pose, fitting_distance
from circumspect.planning.orbit_coverage import camera_bearing, next_turn
from circumspect.planning.planner_input import Finished, NextView, PlannerInput
from circumspect.planning.view_planner import ViewPlanner

NOTHING_KNOWN = "no part of the object is known yet"
ALL_TRIED = "no other view can be reached"
MIN_STEP_DEG, MAX_STEP_DEG = 5.0, 90.0
"""Limits of the step [degrees]: a smaller one counts as reached at once, a larger one misses
sides."""


@dataclass(frozen=True)
class CirclePlanner(ViewPlanner):
    """Moves round the object in steps of a fixed angle, facing its centre.

    Attributes:
        step_deg: Angle between two views, counter-clockwise [degrees].
        distance: Horizontal distance between camera and surface if the object fits the image [m].

    Raises:
        InputError: The step is outside 5 … 90 degrees.
    """

    step_deg: float = 30.0
    distance: float = SURFACE_DISTANCE_M

    def __post_init__(self) -> None:
        require_step("step_deg", self.step_deg)

    def next_view(self, planner_input: PlannerInput) -> NextView | Finished:
        """See `ViewPlanner.next_view`; views that cannot be reached are skipped."""
        if len(planner_input.points_xyz) == 0:
            return Finished(NOTHING_KNOWN)
        if (done := self.check_finished(planner_input)) is not None:
            return done
        turn = float(np.radians(self.step_deg))
        if planner_input.unreachable:
            return view_beyond(planner_input, turn, self.distance)
        return circle_view(planner_input, turn, self.distance)


def require_step(name: str, degrees: float) -> None:
    """Check the angle between two views.

    Raises:
        InputError: It is outside 5 … 90 degrees.
    """
    if not MIN_STEP_DEG <= degrees <= MAX_STEP_DEG:
        raise InputError(
            f"{name} must be {MIN_STEP_DEG:g} … {MAX_STEP_DEG:g} degrees, not {degrees:g}"
        )


def view_beyond(planner_input: PlannerInput, step: float, distance: float) -> NextView | Finished:
    """The next view on a circle, at least `step` [rad] beyond the unreachable views."""
    turn = next_turn(planner_input, step)
    if turn is None:
        return Finished(ALL_TRIED)
    return circle_view(planner_input, turn, distance)


def circle_view(planner_input: PlannerInput, turn: float, distance: float) -> NextView:
    """The view `turn` [rad] further round than the camera, facing the object's centre.

    The circle is `distance` [m] outside the known part, or farther away on sides from which the
    object would not fit the image.
    """
    centre = planner_input.centre_xy
    bearing = camera_bearing(planner_input, planner_input.T_map_base) + turn
    outward = np.array([np.cos(bearing), np.sin(bearing)])
    offset = planner_input.points_xyz[:, :2] - centre
    fitting = float((offset @ outward).max()) + fitting_distance(planner_input, outward, distance)
    away = max(fitting, float(np.linalg.norm(offset, axis=1).max()) + distance)
    place = base_pose(centre + away * outward, centre, planner_input.T_base_camera)
    reason = f"{np.degrees(turn):.0f}° further round, {away:.2f} m from the centre"
    return NextView(place, (float(centre[0]), float(centre[1])), None, reason)
