"""Where to look from next, and how to get there."""

from circumspect.planning.alternatives import alternatives
from circumspect.planning.answer import ENOUGH_SEEN, Answer
from circumspect.planning.circle_planner import CirclePlanner
from circumspect.planning.conviction import Conviction
from circumspect.planning.convinced_planner import ConvincedPlanner
from circumspect.planning.next_view import Finished, NextView
from circumspect.planning.plan_view import footprint
from circumspect.planning.rounds import bearing_turned, sectors_visited
from circumspect.planning.route import NoWay, Route, passable, route
from circumspect.planning.situation import Situation
from circumspect.planning.stance import (
    IMAGE_SHARE,
    SURFACE_DISTANCE,
    camera_place,
    fitting_distance,
    stance,
)
from circumspect.planning.surface_normal_planner import SurfaceNormalPlanner
from circumspect.planning.view_planner import ViewPlanner

__all__ = [
    "ENOUGH_SEEN",
    "IMAGE_SHARE",
    "SURFACE_DISTANCE",
    "Answer",
    "CirclePlanner",
    "Conviction",
    "ConvincedPlanner",
    "Finished",
    "NextView",
    "NoWay",
    "Route",
    "Situation",
    "SurfaceNormalPlanner",
    "ViewPlanner",
    "alternatives",
    "bearing_turned",
    "camera_place",
    "fitting_distance",
    "footprint",
    "passable",
    "route",
    "sectors_visited",
    "stance",
]
