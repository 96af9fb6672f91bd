"""The controls of a live run: pause, step, speed, faults by hand, and the next run's object."""

from __future__ import annotations

import queue
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from circumspect.robot import Operator
from circumspect.viewer.clipped import clipped

if TYPE_CHECKING:
    import viser

    from circumspect.viewer.dashboard import Dashboard

PACES: dict[str, float | None] = {
    "as fast as it can": None, "10 frames/s": 10.0, "4 frames/s": 4.0, "1 frame/s": 1.0,
}  # fmt: skip
PAUSE, RESUME = "Pause", "Go on"
PLANNERS = ("normals", "circle", "convinced")
LOST_SHARES = {"none": 0.0, "30 %": 0.3, "60 %": 0.6}


@dataclass(frozen=True)
class RunRequest:
    """The run that somebody wants.

    Attributes:
        thing: Name of the object, from the list that was offered.
        start_deg: Azimuth of the start [degrees].
        planner: One of `PLANNERS`.
    """

    thing: str
    start_deg: float
    planner: str


class RunControls:
    """Adds its controls to a dashboard.

    What a browser sends is looked up in what was offered, or clipped; nothing else is believed.

    Attributes:
        operator: Of the run that goes on; None between runs.
        requests: The runs that somebody wants.
    """

    def __init__(self, dashboard: Dashboard, things: tuple[str, ...], first: RunRequest) -> None:
        """Show them.

        Args:
            dashboard: Gets the controls.
            things: Objects to choose from.
            first: What runs now; its object is offered, too.
        """
        self.operator: Operator | None = None
        self.requests: queue.Queue[RunRequest] = queue.Queue()
        self._things = things if first.thing in things else (first.thing, *things)
        gui = dashboard.server.gui
        with gui.add_folder("Run", order=-1.0):
            self.pause = gui.add_button(PAUSE)
            self.step = gui.add_button("One frame")
            self.pace = gui.add_dropdown("speed", tuple(PACES), hint="frames let through")
            self.cover = gui.add_checkbox("cover the camera", initial_value=False)
            self.lose = gui.add_dropdown("drop frames", tuple(LOST_SHARES))
        with dashboard.panel.tabs.add_tab("New run"):
            self.thing = gui.add_dropdown("object", self._things, initial_value=first.thing)
            start = float(round(first.start_deg % 360.0))
            self.start = gui.add_slider("start [°]", 0.0, 360.0, 1.0, start)
            self.planner = gui.add_dropdown("planner", PLANNERS, initial_value=first.planner)
            self.begin = gui.add_button("Start")
        dashboard.when_left(self.let_go)
        self._listen()

    def take(self, operator: Operator) -> None:
        """Steer a run that begins; what was set before stays set."""
        self.operator = operator
        self.pause.label = PAUSE
        self._apply()

    def release(self) -> None:
        """The run is over; there is nothing to steer until the next one."""
        self.operator = None

    def let_go(self) -> None:
        """Nobody is there any more: a run that was paused goes on, the camera is uncovered."""
        if self.operator is None:
            return
        self.cover.value, self.pause.label = False, PAUSE
        self.operator.cover(False)
        self.operator.resume()

    def wanted(self) -> RunRequest:
        """What the controls say now."""
        thing, planner = str(self.thing.value), str(self.planner.value)
        return RunRequest(
            thing if thing in self._things else self._things[0],
            clipped(self.start.value, 0.0, 360.0),
            planner if planner in PLANNERS else PLANNERS[0],
        )

    def _apply(self) -> None:
        operator = self.operator
        if operator is not None:
            operator.hurry(PACES.get(str(self.pace.value)))
            operator.drop(LOST_SHARES.get(str(self.lose.value), 0.0))
            operator.cover(self.cover.value is True)

    def _listen(self) -> None:
        for control in (self.pace, self.lose, self.cover):
            self._on_update(control)

        @self.pause.on_click
        def _(event: Any) -> None:  # noqa: ARG001
            if self.operator is None:
                return
            if self.operator.paused:
                self.operator.resume()
            else:
                self.operator.pause()
            self.pause.label = RESUME if self.operator.paused else PAUSE

        @self.step.on_click
        def _(event: Any) -> None:  # noqa: ARG001
            if self.operator is not None:
                self.operator.step()
                self.pause.label = RESUME

        @self.begin.on_click
        def _(event: Any) -> None:  # noqa: ARG001
            self.requests.put(self.wanted())
            if self.operator is not None:
                self.operator.stop()

    def _on_update(self, control: viser.GuiInputHandle[Any]) -> None:
        @control.on_update
        def _(event: Any) -> None:  # noqa: ARG001 - the control knows
            self._apply()
