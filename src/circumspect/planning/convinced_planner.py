"""Ours: drives on only while more views may still change the answer."""

from __future__ import annotations

from dataclasses import dataclass, field

from circumspect.planning.circle_planner import CirclePlanner
from circumspect.planning.conviction import Conviction
from circumspect.planning.next_view import Finished, NextView
from circumspect.planning.situation import Situation
from circumspect.planning.view_planner import ViewPlanner


@dataclass(frozen=True)
class ConvincedPlanner(ViewPlanner):
    """Leaves the views to another planner and stops once the answer is final.

    Attributes:
        views: Chooses the views; by default a circle in large steps, for the shortest way.
        conviction: When the answer is final.
    """

    views: ViewPlanner = field(default_factory=lambda: CirclePlanner(step_deg=45.0))
    conviction: Conviction = field(default_factory=Conviction)

    def next_view(self, situation: Situation) -> NextView | Finished:
        """See `ViewPlanner.next_view`."""
        return self.enough(situation) or self.views.next_view(situation)

    def enough(self, situation: Situation) -> Finished | None:
        """See `ViewPlanner.enough`."""
        why = self.conviction.reached(situation.answers)
        return Finished(why) if why is not None else self.views.enough(situation)
