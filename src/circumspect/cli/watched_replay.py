"""Dashboards that show and control scans, replays and nodes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from circumspect.ros.recognition_node import RESET, START, STOP

if TYPE_CHECKING:
    from circumspect.classification import Prediction
    from circumspect.exploration.simulated_scan import SimulatedScan
    from circumspect.recognition import PipelineObserver, RecognitionStep
    from circumspect.robot import Operator
    from circumspect.ros.health import Status
    from circumspect.ros.recognition_node import RecognitionNode
    from circumspect.sensing import RgbdFrame
    from circumspect.viewer import Dashboard, LiveWatch
    from circumspect.viewer.run_controls import RunControls


class NodeWatch:
    """Shows a node in a dashboard; a `NodeObserver`."""

    def __init__(self, dashboard: Dashboard) -> None:
        """Store the dashboard; `begin` starts the display."""
        self._dashboard = dashboard
        self._node: RecognitionNode | None = None
        self._watch: LiveWatch | None = None

    def begin(self, node: RecognitionNode) -> None:
        """Start to show a node, and add buttons that control it."""
        self._node = node
        self._restart_watch()
        gui = self._dashboard.server.gui
        with gui.add_folder("Node", order=-1.0):
            for label, command in (("Start", START), ("Stop", STOP), ("Model again", RESET)):
                button = gui.add_button(label)

                @button.on_click
                def _(event: Any, command: str = command) -> None:  # noqa: ARG001
                    node.command(command)

    def on_step(self, step: RecognitionStep) -> None:
        """Show the result of a frame."""
        if self._watch is not None:
            self._watch.on_step(step)

    def on_finalised(self, prediction: Prediction) -> None:
        """Show the final answer."""
        if self._watch is not None:
            self._watch.settled(prediction)

    def on_status(self, status: Status) -> None:
        """Show a changed state, which may explain missing frames."""
        if self._watch is not None and self._watch.message != status.text:
            self._watch.show_message(status.text)

    def on_command(self, command: str) -> None:
        """Clear the page on a reset."""
        if command == RESET:
            self._restart_watch()

    def _restart_watch(self) -> None:
        from circumspect.viewer import LiveWatch
        from circumspect.viewer.dashboard_state import DashboardState

        assert self._node is not None
        self._watch = LiveWatch(self._node, self._dashboard)
        self._dashboard.put(lambda: DashboardState((), 0))


class ScanWatch:
    """Connects a scan with the dashboard."""

    def __init__(self, dashboard: Dashboard, controls: RunControls) -> None:
        self._dashboard, self._controls = dashboard, controls
        self._operator: Operator | None = None

    def operated(self, parts: SimulatedScan) -> SimulatedScan:
        """The scan with a robot that obeys the controls."""
        from circumspect.robot import OperatedRobot, Operator

        self._operator = Operator()
        seed = int(parts.config["seed"])
        return parts.driven_by(OperatedRobot(parts.scan.robot, self._operator, seed))

    def observers(self, parts: SimulatedScan) -> tuple[PipelineObserver, ...]:
        """The observers that show the scan; called just before it starts."""
        from circumspect.viewer import LiveWatch

        assert self._operator is not None
        self._controls.take(self._operator)
        truth = parts.config.get("truth")
        scene, ground_truth = parts.room.scene, parts.ground_truth
        return (LiveWatch(parts.scan, self._dashboard, scene, ground_truth, truth),)


class ReplayWatch:
    """Connects a replay with the dashboard."""

    def __init__(self, dashboard: Dashboard) -> None:
        from circumspect.viewer.run_controls import RunControls

        self._dashboard, self._controls = dashboard, RunControls(dashboard)

    def watched(
        self, frames: Iterable[RgbdFrame]
    ) -> tuple[Iterable[RgbdFrame], tuple[PipelineObserver, ...]]:
        """The frames under the control of the dashboard, and the observers that show results."""
        from circumspect.robot import Operator
        from circumspect.viewer import LiveWatch
        from circumspect.viewer.run_controls import OperatedFrames

        operator = Operator()
        self._controls.take(operator)
        operated = OperatedFrames(frames, operator)
        return operated, (LiveWatch(operated, self._dashboard),)
