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
        object_name: Name of the object, from the offered list.
        start_deg: Azimuth of the start [degrees].
        planner: Name of a view planner, from the offered list.
    """

    object_name: str
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
        object_names: tuple[str, ...],
        first: RunRequest,
    ) -> None:
        """Add the tab.

        Args:
            dashboard: The dashboard.
            controls: Controls of the current run, which stops when another one is requested.
            object_names: Objects to choose from.
            first: The current run; its object is offered as well.
        """
        self.requests: queue.Queue[RunRequest] = queue.Queue()
        self._object_names = (
            object_names
            if first.object_name in object_names
            else (first.object_name, *object_names)
        )
        # MODULE:NAME of the first run is offered as well.
        self._planners = tuple(dict.fromkeys((*PLANNER_REGISTRY.names(), first.planner)))
        gui = dashboard.server.gui
        with dashboard.panel.tabs.add_tab("New run"):
            self.object_name = gui.add_dropdown(
                "object", self._object_names, initial_value=first.object_name
            )
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
        object_name, planner = str(self.object_name.value), str(self.planner.value)
        return RunRequest(
            object_name if object_name in self._object_names else self._object_names[0],
            clipped(self.start.value, 0.0, 360.0),
            planner if planner in self._planners else self._planners[0],
        )
