"""Views on a circle round what is known of the object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.errors import InputError
from circumspect.planning.next_view import Finished, NextView
from circumspect.planning.rounds import camera_bearing, next_turn
from circumspect.planning.situation import Situation
from circumspect.planning.stance import SURFACE_DISTANCE, fitting_distance, stance
from circumspect.planning.view_planner import ViewPlanner

NOTHING_KNOWN = "nothing of the object is known yet"
ALL_TRIED = "no other view can be reached"
SMALLEST_STEP, LARGEST_STEP = 5.0, 90.0
"""A view nearer than the first counts as reached before the robot has moved; steps larger than the
second leave sides unseen [degrees]."""


@dataclass(frozen=True)
class CirclePlanner(ViewPlanner):
    """Goes on by a set angle, looking at the object's centre.

    Attributes:
        step_deg: From one view to the next, counter-clockwise [degrees].
        distance: Level distance of camera and surface where the object fits the image [m].

    Raises:
        InputError: A step outside of 5 … 90 degrees.
    """

    step_deg: float = 30.0
    distance: float = SURFACE_DISTANCE

    def __post_init__(self) -> None:
        require_step("step_deg", self.step_deg)

    def next_view(self, situation: Situation) -> NextView | Finished:
        """See `ViewPlanner.next_view`; views that can not be reached are skipped."""
        if len(situation.points_xyz) == 0:
            return Finished(NOTHING_KNOWN)
        if (done := self.enough(situation)) is not None:
            return done
        turn = float(np.radians(self.step_deg))
        if situation.unreachable:
            return beyond(situation, turn, self.distance)
        return circle_view(situation, turn, self.distance)


def require_step(name: str, degrees: float) -> None:
    """Refuse an angle between views with which no round would come to an end.

    Raises:
        InputError: It is outside of 5 … 90 degrees.
    """
    if not SMALLEST_STEP <= degrees <= LARGEST_STEP:
        raise InputError(
            f"{name} must be {SMALLEST_STEP:g} … {LARGEST_STEP:g} degrees, not {degrees:g}"
        )


def beyond(situation: Situation, step: float, distance: float) -> NextView | Finished:
    """The next view on a circle, `step` [rad] or more beyond those that could not be reached."""
    turn = next_turn(situation, step)
    if turn is None:
        return Finished(ALL_TRIED)
    return circle_view(situation, turn, distance)


def circle_view(situation: Situation, turn: float, distance: float) -> NextView:
    """The view `turn` [rad] further round than the camera, looking at the object's centre.

    The circle is `distance` [m] outside of all that is known, or further off on sides from which
    the object would not fit the image.
    """
    centre = situation.centre_xy
    bearing = camera_bearing(situation, situation.T_map_base) + turn
    outward = np.array([np.cos(bearing), np.sin(bearing)])
    offset = situation.points_xyz[:, :2] - centre
    fitting = float((offset @ outward).max()) + fitting_distance(situation, outward, distance)
    away = max(fitting, float(np.linalg.norm(offset, axis=1).max()) + distance)
    place = stance(centre + away * outward, centre, situation.T_base_camera)
    why = f"{np.degrees(turn):.0f}° further round, {away:.2f} m from the centre"
    return NextView(place, (float(centre[0]), float(centre[1])), None, why)
