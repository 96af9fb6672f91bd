"""Where to look from next, and how to get there."""

from circumspect.planning.alternatives import alternatives
from circumspect.planning.answer import Answer
from circumspect.planning.circle_planner import CirclePlanner
from circumspect.planning.confidence_planner import ConfidencePlanner
from circumspect.planning.next_view import Finished, NextView
from circumspect.planning.plan_view import footprint
from circumspect.planning.registry import PLANNER_REGISTRY, PLANNERS, make_planner
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
from circumspect.planning.stopping_criterion import StoppingCriterion
from circumspect.planning.surface_normal_planner import SurfaceNormalPlanner
from circumspect.planning.view_planner import ViewPlanner

__all__ = [
    "IMAGE_SHARE",
    "PLANNERS",
    "PLANNER_REGISTRY",
    "SURFACE_DISTANCE",
    "Answer",
    "CirclePlanner",
    "ConfidencePlanner",
    "Finished",
    "NextView",
    "NoWay",
    "Route",
    "Situation",
    "StoppingCriterion",
    "SurfaceNormalPlanner",
    "ViewPlanner",
    "alternatives",
    "bearing_turned",
    "camera_place",
    "fitting_distance",
    "footprint",
    "make_planner",
    "passable",
    "route",
    "sectors_visited",
    "stance",
]
