"""Planner that stops as soon as the prediction is confident."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from circumspect.errors import InputError
from circumspect.planning.circle_planner import CirclePlanner
from circumspect.planning.planner_input import Answer, Finished, NextView, PlannerInput
from circumspect.planning.view_planner import ViewPlanner


@dataclass(frozen=True)
class StoppingCriterion:
    """The prediction is final after several consecutive confident frames with the same label.

    The classifier decides what is confident; this criterion has no bounds of its own.

    Attributes:
        frames: Number of consecutive confident predictions.

    Raises:
        InputError: `frames` is below 1.
    """

    frames: int = 3

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise InputError(f"a stopping criterion needs at least 1 frame, not {self.frames}")

    def reached(self, answers: Sequence[Answer]) -> str | None:
        """Why the prediction is final; None if it is not.

        Args:
            answers: Predictions so far, one per frame that showed the object.
        """
        last = answers[-self.frames :]
        if len(last) < self.frames or not all(answer.confident for answer in last):
            return None
        label = last[-1].label
        if any(answer.label != label for answer in last):
            return None
        return f"the answer is confident: {label} in {self.frames} consecutive frames"


@dataclass(frozen=True)
class ConfidencePlanner(ViewPlanner):
    """Uses another planner for the views and stops once the prediction is final.

    Attributes:
        views: Planner of the views; by default a circle with large steps for a short path.
        criterion: Stopping criterion.
    """

    stops_when_confident = True

    views: ViewPlanner = field(default_factory=lambda: CirclePlanner(step_deg=45.0))
    criterion: StoppingCriterion = field(default_factory=StoppingCriterion)

    def next_view(self, planner_input: PlannerInput) -> NextView | Finished:
        """See `ViewPlanner.next_view`."""
        return self.check_finished(planner_input) or self.views.next_view(planner_input)

    def check_finished(self, planner_input: PlannerInput) -> Finished | None:
        """See `ViewPlanner.check_finished`."""
        reason = self.criterion.reached(planner_input.answers)
        return Finished(reason) if reason is not None else self.views.check_finished(planner_input)
