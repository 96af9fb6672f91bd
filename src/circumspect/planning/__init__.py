"""View planning and path planning."""

from circumspect.planning.base_pose import (
    MAX_IMAGE_FRACTION,
    SURFACE_DISTANCE_M,
    alternatives,
    base_pose,
    camera_place,
    fitting_distance,
)
from circumspect.planning.circle_planner import CirclePlanner
from circumspect.planning.confidence_planner import ConfidencePlanner, StoppingCriterion
from circumspect.planning.orbit_coverage import bearing_turned, sectors_visited
from circumspect.planning.plan_view import footprint
from circumspect.planning.planner_input import Answer, Finished, NextView, PlannerInput
from circumspect.planning.registry import PLANNER_REGISTRY, PLANNERS, make_planner
from circumspect.planning.route import NoPath, Route, is_free, route
from circumspect.planning.surface_normal_planner import SurfaceNormalPlanner
from circumspect.planning.view_planner import ViewPlanner

__all__ = [
    "MAX_IMAGE_FRACTION",
    "PLANNERS",
    "PLANNER_REGISTRY",
    "SURFACE_DISTANCE_M",
    "Answer",
    "CirclePlanner",
    "ConfidencePlanner",
    "Finished",
    "NextView",
    "NoPath",
    "PlannerInput",
    "Route",
    "StoppingCriterion",
    "SurfaceNormalPlanner",
    "ViewPlanner",
    "alternatives",
    "base_pose",
    "bearing_turned",
    "camera_place",
    "fitting_distance",
    "footprint",
    "is_free",
    "make_planner",
    "route",
    "sectors_visited",
]
