"""Base class of view planners."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from circumspect.planning.orbit_coverage import bearing_turned, is_orbit_covered, unreachable_bases
from circumspect.planning.planner_input import Finished, NextView, PlannerInput

ROUND_COMPLETE = "once round the object"
AS_FAR_AS_POSSIBLE = "round the object as far as it can be reached"
FULL_ROUND_DEG = 360.0


class ViewPlanner(ABC):
    """Chooses the robot's next view of an object on its left.

    Attributes:
        stops_when_confident: Whether a confident answer ends the scan.
    """

    stops_when_confident: ClassVar[bool] = False

    @abstractmethod
    def next_view(self, planner_input: PlannerInput) -> NextView | Finished:
        """The next view; called when the robot has stopped."""

    def check_finished(self, planner_input: PlannerInput) -> Finished | None:
        """The reason to finish, or None; called after every frame, also while driving."""
        if bearing_turned(planner_input) >= FULL_ROUND_DEG:
            return Finished(
                AS_FAR_AS_POSSIBLE if unreachable_bases(planner_input) else ROUND_COMPLETE
            )
        if is_orbit_covered(planner_input):
            return Finished(AS_FAR_AS_POSSIBLE)
        return None
