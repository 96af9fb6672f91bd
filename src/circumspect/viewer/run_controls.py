"""The controls of a live run: pause, step, speed, and faults by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from circumspect.robot import Operator

if TYPE_CHECKING:
    import viser

    from circumspect.viewer.dashboard import Dashboard

PACES: dict[str, float | None] = {
    "as fast as it can": None, "10 frames/s": 10.0, "4 frames/s": 4.0, "1 frame/s": 1.0,
}  # fmt: skip
PAUSE, RESUME = "Pause", "Go on"
LOST_SHARES = {"none": 0.0, "30 %": 0.3, "60 %": 0.6}


class RunControls:
    """Adds its controls to a dashboard.

    What a browser sends is looked up in what was offered, or clipped; nothing else is believed.

    Attributes:
        operator: Of the run that goes on; None between runs.
    """

    def __init__(self, dashboard: Dashboard) -> None:
        """Show them.

        Args:
            dashboard: Gets the controls.
        """
        self.operator: Operator | None = None
        gui = dashboard.server.gui
        with gui.add_folder("Run", order=-1.0):
            # Without a run there is nothing to steer: a click would be lost.
            self.pause = gui.add_button(PAUSE, disabled=True)
            self.step = gui.add_button("One frame", disabled=True)
            self.pace = gui.add_dropdown("speed", tuple(PACES), hint="frames let through")
            self.cover = gui.add_checkbox("cover the camera", initial_value=False)
            self.lose = gui.add_dropdown("drop frames", tuple(LOST_SHARES))
        dashboard.when_left(self.let_go)
        self._listen()

    def take(self, operator: Operator) -> None:
        """Steer a run that begins; what was set before stays set."""
        self.operator = operator
        self.pause.label = PAUSE
        self.pause.disabled = self.step.disabled = False
        self._apply()

    def release(self) -> None:
        """The run is over; there is nothing to steer until the next one."""
        self.operator = None
        self.pause.label = PAUSE
        self.pause.disabled = self.step.disabled = True

    def let_go(self) -> None:
        """Nobody is there any more: a run that was paused goes on, the camera is uncovered."""
        if self.operator is None:
            return
        self.cover.value, self.pause.label = False, PAUSE
        self.operator.cover(False)
        self.operator.resume()

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

    def _on_update(self, control: viser.GuiInputHandle[Any]) -> None:
        @control.on_update
        def _(event: Any) -> None:  # noqa: ARG001 - the control knows
            self._apply()
