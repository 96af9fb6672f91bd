"""Ours: stops as soon as the answer is confident."""

from __future__ import annotations

from dataclasses import dataclass, field

from circumspect.planning.circle_planner import CirclePlanner
from circumspect.planning.next_view import Finished, NextView
from circumspect.planning.situation import Situation
from circumspect.planning.stopping_criterion import StoppingCriterion
from circumspect.planning.view_planner import ViewPlanner


@dataclass(frozen=True)
class ConfidencePlanner(ViewPlanner):
    """Leaves the views to another planner and stops once the answer is final.

    Attributes:
        views: Chooses the views; by default a circle in large steps, for the shortest way.
        criterion: When the answer is final.
    """

    views: ViewPlanner = field(default_factory=lambda: CirclePlanner(step_deg=45.0))
    criterion: StoppingCriterion = field(default_factory=StoppingCriterion)

    def next_view(self, situation: Situation) -> NextView | Finished:
        """See `ViewPlanner.next_view`."""
        return self.enough(situation) or self.views.next_view(situation)

    def enough(self, situation: Situation) -> Finished | None:
        """See `ViewPlanner.enough`."""
        why = self.criterion.reached(situation.answers)
        return Finished(why) if why is not None else self.views.enough(situation)
