"""`circumspect scan --viewer`: runs that are shown, steered and chosen in the browser."""

from __future__ import annotations

import queue
from dataclasses import replace
from typing import TYPE_CHECKING

from circumspect.cli.say import say

if TYPE_CHECKING:
    from circumspect.cli.scan import Scan
    from circumspect.exploration.simulated_scan import SimulatedScan
    from circumspect.recognition import PipelineObserver
    from circumspect.robot import Operator
    from circumspect.viewer import Dashboard
    from circumspect.viewer.next_run import NextRun, RunRequest
    from circumspect.viewer.run_controls import RunControls


class ScanWatch:
    """Puts the dashboard round one scan."""

    def __init__(self, dashboard: Dashboard, controls: RunControls) -> None:
        self._dashboard, self._controls = dashboard, controls
        self._operator: Operator | None = None

    def operated(self, parts: SimulatedScan) -> SimulatedScan:
        """The scan with a robot that listens to the controls."""
        from circumspect.robot import OperatedRobot, Operator

        self._operator = Operator()
        seed = int(parts.config["seed"])
        return parts.driven_by(OperatedRobot(parts.scan.robot, self._operator, seed))

    def observers(self, parts: SimulatedScan) -> tuple[PipelineObserver, ...]:
        """Who shows the scan; called when it is about to begin."""
        from circumspect.viewer import LiveWatch

        assert self._operator is not None
        self._controls.take(self._operator)
        truth = parts.config.get("truth")
        scene, witness = parts.room.scene, parts.witness
        return (LiveWatch(parts.scan, self._dashboard, scene, witness, truth),)


def watched_scans(scan: Scan, command: str) -> int:
    """Run a scan with the dashboard, then those that are asked for there, until Ctrl-C.

    Args:
        scan: The command's flags.
        command: What runs' folders are named after.
    """
    from circumspect.classification import Classifier
    from circumspect.furniture import CATEGORIES
    from circumspect.robot import RunStopped
    from circumspect.viewer.next_run import NextRun, RunRequest
    from circumspect.viewer.run_controls import RunControls

    running, parts = scan, scan.prepared(command)
    first = RunRequest(scan.object, float(parts.config["start_deg"]), str(parts.config["planner"]))
    ended = False
    with scan.page.opened(Classifier.load(scan.model)) as dashboard:
        controls = RunControls(dashboard)
        following = NextRun(dashboard, controls, tuple(CATEGORIES), first)
        watch = ScanWatch(dashboard, controls)
        try:
            while True:
                try:
                    running.scan(parts, command, watch)
                except RunStopped:
                    say("stopped; another run was asked for")
                ended = True
                controls.release()
                running, parts = _following(scan, command, following)
                ended = False
        except KeyboardInterrupt:
            if not ended:
                raise
            say("the dashboard is closed")
    return 0


def _following(first: Scan, command: str, following: NextRun) -> tuple[Scan, SimulatedScan]:
    """The next run that somebody asks for; waits for it.

    Args:
        first: The command's flags, which hold for its object whenever that is asked for again.
        command: What runs' folders are named after.
        following: Where it is asked for.
    """
    from circumspect.errors import CircumspectError

    say("the page stays open: start another run there, or end with Ctrl-C")
    while True:
        request = _latest(following.requests)
        # What was named or recorded for the first run is not for the next one.
        wanted = replace(
            first, object=request.thing, start=request.start_deg, planner=request.planner,
            seed=None, out=None, record=None,
        )  # fmt: skip
        if request.thing != first.object:
            wanted = replace(wanted, data=None, up=None, height=None)
        try:
            return wanted, wanted.prepared(command)
        except CircumspectError as error:
            say(str(error))


def _latest(requests: queue.Queue[RunRequest]) -> RunRequest:
    request = requests.get()
    while not requests.empty():
        request = requests.get_nowait()
    return request
