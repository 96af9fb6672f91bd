"""Views on a circle round what is known of the object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.planning.next_view import Finished, NextView
from circumspect.planning.plan_view import centre_of
from circumspect.planning.rounds import ahead, bearings_of
from circumspect.planning.situation import Situation
from circumspect.planning.stance import SURFACE_DISTANCE, fitting_distance, stance
from circumspect.planning.view_planner import ViewPlanner

NOTHING_KNOWN = "nothing of the object is known yet"
ALL_TRIED = "no other view can be reached"
BEHIND = float(np.radians(15.0))
"""A view less than this behind the robot is behind it, not ahead round the object [rad]."""


@dataclass(frozen=True)
class CirclePlanner(ViewPlanner):
    """Goes on by a set angle, looking at the object's centre.

    Attributes:
        step_deg: From one view to the next, counter-clockwise [degrees].
        distance: Level distance of camera and surface where the object fits the image [m].
    """

    step_deg: float = 30.0
    distance: float = SURFACE_DISTANCE

    def next_view(self, situation: Situation) -> NextView | Finished:
        """See `ViewPlanner.next_view`; views that can not be reached are skipped."""
        if len(situation.points_xyz) == 0:
            return Finished(NOTHING_KNOWN)
        if (done := self.enough(situation)) is not None:
            return done
        turn = furthest_tried(situation) + np.radians(self.step_deg)
        if turn >= 2 * np.pi:
            return Finished(ALL_TRIED)
        return circle_view(situation, float(turn), self.distance)


def furthest_tried(situation: Situation) -> float:
    """Angle [rad] from the robot on to the furthest view that no way led to; 0 without any."""
    centre = centre_of(situation.points_xyz)
    here = situation.T_map_base
    turns = [ahead(here, view.T_map_base, centre) for view in situation.unreachable]
    # What is a little behind is not almost once round.
    return max((turn for turn in turns if turn < 2 * np.pi - BEHIND), default=0.0)


def circle_view(situation: Situation, turn: float, distance: float) -> NextView:
    """The view `turn` [rad] further round than the robot, looking at the object's centre."""
    centre = centre_of(situation.points_xyz)
    bearing = float(bearings_of([situation.T_map_base.xy], centre)[0]) + turn
    outward = np.array([np.cos(bearing), np.sin(bearing)])
    reach = float(((situation.points_xyz[:, :2] - centre) @ outward).max())
    away = reach + fitting_distance(situation, outward, distance)
    place = stance(centre + away * outward, centre, situation.T_base_camera)
    why = f"{np.degrees(turn):.0f}° further round, {away:.2f} m from the centre"
    return NextView(place, (float(centre[0]), float(centre[1])), None, why)
