"""Controls of a live run or a replay: pause, step, speed and faults."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from circumspect.robot import Operator
from circumspect.sensing import RgbdFrame

if TYPE_CHECKING:
    import viser

    from circumspect.viewer.dashboard import Dashboard

PACES: dict[str, float | None] = {
    "as fast as it can": None, "10 frames/s": 10.0, "4 frames/s": 4.0, "1 frame/s": 1.0,
}  # fmt: skip
PAUSE, RESUME = "Pause", "Go on"
LOST_SHARES = {"none": 0.0, "30 %": 0.3, "60 %": 0.6}


class OperatedFrames:
    """Iterates over frames as commanded by an operator; a `Watchable`.

    Attributes:
        frame: The current frame.
        target: Always None, because a recording has no next view.
        ended: Why the frames ended; None before.
    """

    def __init__(self, frames: Iterable[RgbdFrame], operator: Operator, seed: int = 0) -> None:
        """Set frames and operator; no frame is taken yet.

        Args:
            frames: Frames in the order of their stamps.
            operator: Receives the commands.
            seed: Seed that selects lost frames.
        """
        self.frame: RgbdFrame | None = None
        self.target = None
        self.ended: str | None = None
        self._frames, self._operator = frames, operator
        self._rng = np.random.default_rng(seed)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """The frames, each as soon as the operator allows it.

        Raises:
            RunStopped: The operator stopped the run.
        """
        for frame in self._frames:
            self._operator.wait_for_frame()
            if self._rng.random() < self._operator.dropped:
                continue
            self.frame = frame.covered() if self._operator.covered else frame
            yield self.frame
        self.ended = "the end of the recording"


class RunControls:
    """Controls of a run in a dashboard.

    Values from the browser are untrusted: they are clipped or must be in the offered lists.

    Attributes:
        operator: Operator of the current run; None between runs.
    """

    def __init__(self, dashboard: Dashboard) -> None:
        """Add the controls.

        Args:
            dashboard: The dashboard.
        """
        self.operator: Operator | None = None
        gui = dashboard.server.gui
        with gui.add_folder("Run", order=-1.0):
            # Disabled without a run, because a click would have no effect.
            self.pause = gui.add_button(PAUSE, disabled=True)
            self.step = gui.add_button("One frame", disabled=True)
            self.pace = gui.add_dropdown("speed", tuple(PACES), hint="frames let through")
            self.cover = gui.add_checkbox("cover the camera", initial_value=False)
            self.lose = gui.add_dropdown("drop frames", tuple(LOST_SHARES))
        dashboard.when_left(self.let_go)
        self._listen()

    def take(self, operator: Operator) -> None:
        """Control a run that starts; previous settings are kept."""
        self.operator = operator
        self.pause.label = PAUSE
        self.pause.disabled = self.step.disabled = False
        self._apply()

    def release(self) -> None:
        """Disable the controls until the next run."""
        self.operator = None
        self.pause.label = PAUSE
        self.pause.disabled = self.step.disabled = True

    def let_go(self) -> None:
        """Resume a paused run and uncover the camera, as no browser is connected any more."""
        if self.operator is None:
            return
        self.cover.value, self.pause.label = False, PAUSE
        self.operator.cover(False)
        self.operator.resume()

    def _apply(self) -> None:
        operator = self.operator
        if operator is not None:
            operator.set_pace(PACES.get(str(self.pace.value)))
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
