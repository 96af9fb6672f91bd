"""The tab where another run is asked for."""

from __future__ import annotations

import queue
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from circumspect.planning import PLANNER_REGISTRY
from circumspect.viewer.clipped import clipped

if TYPE_CHECKING:
    from circumspect.viewer.dashboard import Dashboard
    from circumspect.viewer.run_controls import RunControls


@dataclass(frozen=True)
class RunRequest:
    """The run that somebody wants.

    Attributes:
        thing: Name of the object, from the list that was offered.
        start_deg: Azimuth of the start [degrees].
        planner: Name of a view planner, from the list that was offered.
    """

    thing: str
    start_deg: float
    planner: str


class NextRun:
    """Adds its tab to a dashboard.

    What a browser sends is looked up in what was offered, or clipped; nothing else is believed.

    Attributes:
        requests: The runs that somebody wants.
    """

    def __init__(
        self,
        dashboard: Dashboard,
        controls: RunControls,
        things: tuple[str, ...],
        first: RunRequest,
    ) -> None:
        """Show it.

        Args:
            dashboard: Gets the tab.
            controls: Of the run that goes on; it is stopped when another one is asked for.
            things: Objects to choose from.
            first: What runs now; its object is offered, too.
        """
        self.requests: queue.Queue[RunRequest] = queue.Queue()
        self._things = things if first.thing in things else (first.thing, *things)
        # MODULE:NAME of the first run is offered as well.
        self._planners = tuple(dict.fromkeys((*PLANNER_REGISTRY.names(), first.planner)))
        gui = dashboard.server.gui
        with dashboard.panel.tabs.add_tab("New run"):
            self.thing = gui.add_dropdown("object", self._things, initial_value=first.thing)
            start = float(round(first.start_deg % 360.0))
            self.start = gui.add_slider("start [°]", 0.0, 360.0, 1.0, start)
            self.planner = gui.add_dropdown("planner", self._planners, initial_value=first.planner)
            self.begin = gui.add_button("Start")

        @self.begin.on_click
        def _(event: Any) -> None:  # noqa: ARG001
            self.requests.put(self.wanted())
            if controls.operator is not None:
                controls.operator.stop()

    def wanted(self) -> RunRequest:
        """What the tab says now."""
        thing, planner = str(self.thing.value), str(self.planner.value)
        return RunRequest(
            thing if thing in self._things else self._things[0],
            clipped(self.start.value, 0.0, 360.0),
            planner if planner in self._planners else self._planners[0],
        )
