"""The dashboard tab that requests another run."""

from __future__ import annotations

import queue
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from circumspect.planning import PLANNER_REGISTRY
from circumspect.viewer.guarded_server import clipped

if TYPE_CHECKING:
    from circumspect.viewer.dashboard import Dashboard
    from circumspect.viewer.run_controls import RunControls


@dataclass(frozen=True)
class RunRequest:
    """A requested run.

    Attributes:
        thing: Name of the object, from the offered list.
        start_deg: Azimuth of the start [degrees].
        planner: Name of a view planner, from the offered list.
    """

    thing: str
    start_deg: float
    planner: str


class NextRun:
    """Tab of a dashboard that requests another run.

    Values from the browser are untrusted: they are clipped or must be in the offered lists.

    Attributes:
        requests: Queue of requested runs.
    """

    def __init__(
        self,
        dashboard: Dashboard,
        controls: RunControls,
        things: tuple[str, ...],
        first: RunRequest,
    ) -> None:
        """Add the tab.

        Args:
            dashboard: The dashboard.
            controls: Controls of the current run, which stops when another one is requested.
            things: Objects to choose from.
            first: The current run; its object is offered as well.
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
        """The run that is currently selected."""
        thing, planner = str(self.thing.value), str(self.planner.value)
        return RunRequest(
            thing if thing in self._things else self._things[0],
            clipped(self.start.value, 0.0, 360.0),
            planner if planner in self._planners else self._planners[0],
        )
