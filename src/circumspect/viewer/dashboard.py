"""The dashboard: 3D view and panel in one page, updated in its own thread."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Self

import numpy as np

from circumspect.classification import Classifier
from circumspect.viewer.colouring import COLOURINGS, EVIDENCE
from circumspect.viewer.dashboard_state import DashboardState
from circumspect.viewer.guarded_server import address, clipped, guarded_server, stop
from circumspect.viewer.panel import Panel
from circumspect.viewer.publisher import Publisher
from circumspect.viewer.stage import Stage
from circumspect.viewer.turned_object import TurnedObject, turned_object
from circumspect.viewer.why import Why

DEFAULT_HOST, DEFAULT_PORT = "127.0.0.1", 8080


class Dashboard:
    """The dashboard page in the browser; a context manager.

    Attributes:
        server: The viser server, see `guarded_server`.
        stage: The 3D view.
        panel: The panel beside the 3D view.
        publisher: Shows the newest state.
        why: Explains the answer on demand.
        url: Address of the page.
        total: Number of frames in the width of the history; None means all so far.
    """

    def __init__(
        self,
        classifier: Classifier,
        host: str = DEFAULT_HOST,
        port: int = DEFAULT_PORT,
        always: bool = False,
        names: Sequence[str] = (),
    ) -> None:
        """Open the page.

        Args:
            classifier: Classifies the object after the slider rotates it.
            host: Address to listen at.
            port: The port; 0 means any free one.
            always: Whether to show states without a connected browser, as an export does.
            names: Host names that browsers may use, see `guarded_server`.

        Raises:
            InputError: The port is taken.
            MissingExtraError: viser is not installed.
        """
        self.server = guarded_server(host, port, names)
        self.url = address(self.server, host)
        self.stage = Stage(self.server)
        self.panel = Panel(self.server)
        self.total: int | None = None
        self._classifier = classifier
        self._yaw = 0.0
        self.publisher: Publisher[Callable[[], DashboardState | None]] = Publisher(
            self._publish, lambda: always or self.watched
        )
        self.why = Why(classifier, self.publisher.slot.again)
        self._listen()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def watched(self) -> bool:
        """Whether a browser is connected."""
        return bool(self.server.get_clients())

    def put(self, make: Callable[[], DashboardState | None]) -> None:
        """Schedule a state; a newer one replaces it. Returns immediately.

        Args:
            make: Creates the state in the page's thread; if it returns None, nothing is shown.
        """
        self.publisher.slot.put(make)

    def when_left(self, act: Callable[[], None]) -> None:
        """Call `act` whenever the last browser disconnects."""

        @self.server.on_client_disconnect
        def _(client: object) -> None:  # noqa: ARG001 - whoever it was
            if not self.watched:
                act()

    def close(self) -> None:
        """Close the page."""
        self.publisher.close()
        self.why.close()
        with contextlib.suppress(RuntimeError):
            stop(self.server)

    def show(self, state: DashboardState) -> None:
        """Show a state immediately, in the caller's thread."""
        turned = self._turned(state)
        self.why.ask(state.object_snapshot.grid, state.run)
        self.stage.explanation = self.why.found
        self.panel.explain(self.why.html())
        self.stage.yaw = 0.0 if turned is None else turned.yaw
        self.stage.show(state, None if turned is None else turned.grid)
        self.panel.show(state, turned, self.total)

    def _publish(self, make: Callable[[], DashboardState | None]) -> None:
        state = make()
        if state is not None:
            self.show(state)

    def _turned(self, state: DashboardState) -> TurnedObject | None:
        if self._yaw == 0.0:
            return None
        return turned_object(state.object_snapshot, self._yaw, self._classifier)

    def _listen(self) -> None:
        """Show the latest state again after each change of a control."""
        panel, again = self.panel, self.publisher.slot.again

        @panel.turn.on_update
        def _(event: object) -> None:  # noqa: ARG001 - the slider knows
            self._yaw = float(np.radians(clipped(panel.turn.value, 0.0, 360.0) % 360.0))
            again()

        @panel.colouring.on_update
        def _(event: object) -> None:  # noqa: ARG001
            if panel.colouring.value in COLOURINGS:
                self.stage.colouring = panel.colouring.value
                self.why.wanted = panel.colouring.value == EVIDENCE
                again()

        @panel.explain_now.on_click
        def _(event: object) -> None:  # noqa: ARG001
            panel.colouring.value = EVIDENCE

        for name, box in panel.layers.items():

            @box.on_update
            def _(event: object, name: str = name, box: object = box) -> None:  # noqa: ARG001
                self.stage.set_visible(name, bool(getattr(box, "value", True)))
                again()

        @self.server.on_client_connect
        def _(client: object) -> None:  # noqa: ARG001
            again()
