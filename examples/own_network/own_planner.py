"""A view planner of your own: circumspect scan chair --planner own_planner:Zigzag."""

from circumspect.planning import CirclePlanner, Finished, NextView, PlannerInput, ViewPlanner


class Zigzag(ViewPlanner):
    """Goes round in steps that are small and large in turn."""

    def __init__(self) -> None:
        self._steps = (CirclePlanner(step_deg=20.0), CirclePlanner(step_deg=50.0))
        self._views = 0

    def next_view(self, planner_input: PlannerInput) -> NextView | Finished:
        planner = self._steps[self._views % 2]
        self._views += 1
        return planner.next_view(planner_input)
