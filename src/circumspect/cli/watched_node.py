"""`circumspect ros2 --viewer`: a node that is shown, started and stopped in the browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from circumspect.ros.recognition_node import RESET, START, STOP

if TYPE_CHECKING:
    from circumspect.classification import Prediction
    from circumspect.recognition import RecognitionStep
    from circumspect.ros.health import Status
    from circumspect.ros.recognition_node import RecognitionNode
    from circumspect.viewer import Dashboard, LiveWatch


class NodeWatch:
    """Shows a node in a dashboard; a `NodeObserver`."""

    def __init__(self, dashboard: Dashboard) -> None:
        """Show nothing before `begin`."""
        self._dashboard = dashboard
        self._node: RecognitionNode | None = None
        self._watch: LiveWatch | None = None

    def begin(self, node: RecognitionNode) -> None:
        """Watch a node from now on, and let the page command it."""
        self._node = node
        self._watch_anew()
        gui = self._dashboard.server.gui
        with gui.add_folder("Node", order=-1.0):
            for label, command in (("Start", START), ("Stop", STOP), ("Model anew", RESET)):
                button = gui.add_button(label)

                @button.on_click
                def _(event: Any, command: str = command) -> None:  # noqa: ARG001
                    node.command(command)

    def on_step(self, step: RecognitionStep) -> None:
        """Show what a frame led to."""
        if self._watch is not None:
            self._watch.on_step(step)

    def on_settled(self, prediction: Prediction) -> None:
        """Show what all grids say."""
        if self._watch is not None:
            self._watch.settled(prediction)

    def on_status(self, status: Status) -> None:
        """Show the state where it changed: it may be why no frame comes."""
        if self._watch is not None and self._watch.news != status.text:
            self._watch.tell(status.text)

    def on_command(self, command: str) -> None:
        """What is modelled anew begins with an empty page."""
        if command == RESET:
            self._watch_anew()

    def _watch_anew(self) -> None:
        from circumspect.viewer import LiveWatch
        from circumspect.viewer.shown import Shown

        assert self._node is not None
        self._watch = LiveWatch(self._node, self._dashboard)
        self._dashboard.put(lambda: Shown((), 0))
