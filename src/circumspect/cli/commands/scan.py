"""`circumspect scan OBJECT`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.config_file import ConfigFlag, write_config
from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.flag_table import Flags
from circumspect.cli.given_flags import drawn_seed, flags_named
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.errors import CircumspectError, InputError
from circumspect.exploration.scan_settings import RoomSettings, ScanSettings

if TYPE_CHECKING:
    from queue import Queue

    from circumspect.cli.commands.scan_report import ScanReport
    from circumspect.cli.commands.scan_space import ScanSpace
    from circumspect.cli.watched_replay import ScanWatch
    from circumspect.exploration.simulated_scan import SimulatedScan
    from circumspect.planning import ViewPlanner
    from circumspect.recording import RunRecorder
    from circumspect.viewer.next_run import NextRun, RunRequest

WORLD = Flags("slip", "clutter", "mast_height", "wheel_error", tilt_deg="tilt", bump_height="bumps")
DRIVING = Flags("speed", "frame_interval", max_frames="frames")
UNITS = "are its units metres?"
"""End of the messages of errors that a wrong unit of the mesh may cause."""


@dataclass(frozen=True)
class Scan:
    """Let a simulated robot drive round an object, map it and classify it.

    $ circumspect scan chair
    $ circumspect scan sofa-17 --start 135 --slip 0.1 --planner confidence
    $ circumspect scan desk.obj --up y --height 0.75 --stop-when-sure
    $ circumspect scan chair_0890 --data modelnet10 --json
    $ circumspect scan toilet --record toilet.mcap
    $ circumspect scan table --space
    $ circumspect scan sofa --viewer
    """

    object: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="OBJECT")]
    """bathtub, bed, chair, desk, dresser, monitor, night_stand, sofa, table or toilet; one of these
    with a variant, such as chair-17; a mesh file; or, with --data, the name of an object there."""
    start: float | None = None
    """Azimuth of the start [degrees], counter-clockwise from above; random by default."""
    seed: int | None = None
    """Random seed; the same seed gives the same run. New by default."""
    planner: Annotated[str, tyro.conf.arg(metavar="NAME|MODULE:NAME")] = "normals"
    """Planner of the next view. normals: along the surface normals as in the paper; circle: round
    the object; confidence: on a circle until the answer is confident. Or your own planner, by its
    registered name or by MODULE:NAME."""
    stop_when_sure: bool = False
    """End when the answer is confident in three consecutive frames, with any planner."""
    world: Annotated[RoomSettings, WORLD] = field(default_factory=RoomSettings)
    """The room and the errors of the robot."""
    driving: Annotated[ScanSettings, DRIVING] = field(default_factory=ScanSettings)
    """Driving and camera frames."""
    real_time: bool = False
    """Run in real time; as fast as possible by default."""
    space: bool = False
    """Also simulate four ceiling cameras that detect a tag on the robot, and compare the run with
    their poses. The robot does not use them."""
    data: Path | None = None
    """Folder of ModelNet10 with point packs, or with the OFF files that `circumspect data fetch`
    downloads. OBJECT is then the name of an object in it."""
    up: Literal["x", "y", "z"] | None = None
    """Axis that points up in a mesh file. Default: y for glTF/GLB, the axis stated in the file for
    USD, z for all others."""
    height: float | None = None
    """Scale a mesh file to this height [m]; by default its unit is the metre."""
    model: ModelFlag = ROBOT
    """Shipped classifier (`circumspect models` lists them), or your own ONNX file written by
    `circumspect export`."""
    out: Path | None = None
    """Folder of the run; runs/scan-DATE-TIME by default. An earlier run in it is replaced."""
    record: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Record sensor data of the robot, images of the ceiling cameras and answers in a new MCAP
    file. `circumspect replay`, Foxglove and ROS 2 can play it."""
    viewer: bool = False
    """Show and control the run in the browser; the page stays open after the run."""
    page: PageFlags = field(default_factory=PageFlags)
    """Address of the dashboard."""
    json: bool = False
    """Print one JSON line on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self, command: str = "scan", given: Any = None) -> int:
        """Drive, map, classify, save.

        Args:
            command: Name that the run's folder begins with.
            given: The user's command, if it is another one.
        """
        if self.viewer:
            return watched_scans(self, command, given)
        return self.scan(self.prepared(command), command, given=given)

    def scan(
        self,
        parts: SimulatedScan,
        command: str,
        watch: ScanWatch | None = None,
        given: Any = None,
    ) -> int:
        """Run a scan and print the report.

        Args:
            parts: Result of `prepared`.
            command: Name that the run's folder begins with.
            watch: Shows and controls the run in the browser; None means no dashboard.
            given: The user's command, if it is another one.

        Returns:
            Exit code: 0, or `NO_ANSWER`.
        """
        from circumspect.cli.run_screen import NO_ANSWER, RunScreen
        from circumspect.runs.step_recorder import StepRecorder

        scan, recorder = self._recorded(parts if watch is None else watch.operated(parts))
        try:
            report = self._reported(scan, recorder, command)
            path, start = report.folder.path, scan.config["start_deg"]
            name = "scan" if given is None else command
            write_config(path, given or self, name, seed=scan.config["seed"], start=start)
        except BaseException:
            # Without the recording, the user can repeat the same command.
            if recorder is not None:
                recorder.discard()
            raise
        with RunScreen("round the object [°]", 360, report.round_deg) as screen:
            screen.say(report.opening)
            writers = () if recorder is None else (StepRecorder(recorder),)
            shown = () if watch is None else watch.observers(scan)
            try:
                result = scan.scan.run((screen, *shown, *writers, *report.observers))
            except KeyboardInterrupt as interrupt:
                screen.say(f"what was gathered so far is in {report.folder.path}")
                interrupt.add_note(_how_to_repeat(scan.config, watch is not None))
                raise
        report.show(result, self.json, screen.label)
        if recorder is not None and recorder.failure is not None:
            raise recorder.failure
        return NO_ANSWER if result.prediction is None else 0

    def _reported(
        self, scan: SimulatedScan, recorder: RunRecorder | None, command: str
    ) -> ScanReport:
        """The report with the run's folder, and with ceiling cameras if requested."""
        from circumspect.cli.commands.scan_report import ScanReport
        from circumspect.cli.run_screen import new_run_folder

        space = self._watched(scan)
        if space is not None and recorder is not None:
            space.record(recorder)
        return ScanReport(scan, self.out or new_run_folder(command), space)

    def _recorded(self, scan: SimulatedScan) -> tuple[SimulatedScan, RunRecorder | None]:
        """The scan, with a recorder if requested."""
        import json

        from circumspect.recording import RunRecorder
        from circumspect.recording.run_recorder import SYSTEMATIC_DISPARITY

        if self.record is None:
            return scan, None
        noise = scan.config["tracking"]["scan"]["noise"]
        notes = {
            "config": json.dumps(scan.config),
            SYSTEMATIC_DISPARITY: repr(noise["systematic_disparity"]),
        }
        recorder = RunRecorder(self.record, notes)
        return scan.recorded(recorder), recorder

    def prepared(self, command: str) -> SimulatedScan:
        """Prepare the scan; reports all errors in the flags before anything is written."""
        import numpy as np

        from circumspect import __version__
        from circumspect.classification import Classifier
        from circumspect.cli.model_flag import model_record
        from circumspect.exploration.simulated_scan import SimulatedScan
        from circumspect.gathering.scanned_object import scanned_object

        seed = drawn_seed(self.seed)
        # All random values are drawn in any case, so that a given flag does not change the others.
        rng = np.random.default_rng(seed)
        variant, start_deg = int(rng.integers(1000)), float(np.round(rng.uniform(0, 360), 1))
        if self.start is not None:
            start_deg = self.start
        if not np.isfinite(start_deg):
            raise InputError(f"--start {start_deg}: give degrees")
        scanned = scanned_object(self.object, variant, self.up, self.height, self.data)
        config = {
            "command": command,
            "version": __version__,
            "object": scanned.name,
            "true_label": scanned.label,
            "truth": scanned.label,
            "seed": seed,
            "start_deg": start_deg,
            "planner": self.planner,
            "stop_when_sure": self.stop_when_sure,
            "data": None if self.data is None else str(self.data),
            "up": self.up,
            "height": self.height,
        }
        classifier = Classifier.load(self.model)
        config["classifier"] = model_record(self.model)
        checked = ("slip", "wheel_error", "bumps", "mast_height", "tilt")
        try:
            with flags_named(self, *checked):
                return SimulatedScan.prepared(
                    scanned.mesh, self.world, self.driving, self._planner(), classifier, config,
                    colour=self.viewer, real_time=self.real_time,
                )  # fmt: skip
        except InputError as error:
            # The message about an object that does not fit the camera asks for its units.
            if not str(error).endswith(UNITS):
                raise
            raise InputError(f"{error} --height scales it to a height in metres") from error

    def _watched(self, scan: SimulatedScan) -> ScanSpace | None:
        if not self.space:
            return None
        from circumspect.cli.commands.scan_space import ScanSpace

        return ScanSpace(scan)

    def _planner(self) -> ViewPlanner:
        from circumspect.planning import ConfidencePlanner, make_planner

        planner = make_planner(self.planner)
        if self.stop_when_sure and not planner.stops_when_confident:
            return ConfidencePlanner(planner)
        return planner


def _how_to_repeat(config: Mapping[str, Any], chosen_there: bool) -> str:
    """Instructions to repeat a run, including randomly drawn values.

    Args:
        config: Configuration of the run.
        chosen_there: Whether object, start and planner may have been chosen on the page.
    """
    if not chosen_there:
        return f"the same command with --seed {config['seed']} starts the same run again"
    return (
        f"circumspect scan {config['object']} --start {config['start_deg']} --seed {config['seed']}"
        f" --planner {config['planner']} --frame-interval {config['scan']['frame_interval']} and "
        "the other flags start the same run again"
    )


def watched_scans(scan: Scan, command: str, given: Any = None) -> int:
    """Run a scan with the dashboard, then the scans requested there, until Ctrl-C.

    Args:
        scan: The first scan.
        command: Name that the folders of runs begin with.
        given: The user's first command, if it is another one.
    """
    from circumspect.classification import Classifier
    from circumspect.cli.say import say
    from circumspect.cli.watched_replay import ScanWatch
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
                    running.scan(parts, command, watch, given if running is scan else None)
                except RunStopped:
                    say("stopped; another run was requested")
                ended = True
                controls.release()
                running, parts = _next_run(scan, command, following)
                ended = False
        except KeyboardInterrupt:
            if not ended:
                raise
            say("the dashboard is closed")
    return 0


def _next_run(first: Scan, command: str, following: NextRun) -> tuple[Scan, SimulatedScan]:
    """Wait for the next requested run.

    Args:
        first: The first scan. Its flags apply to further runs, those of its mesh only to the same
            object.
        command: Name that the folders of runs begin with.
        following: Requests from the page.
    """
    from circumspect.cli.say import say

    say("the page stays open: start another run there, or end with Ctrl-C")
    while True:
        request = _latest(following.requests)
        # Seed, folder and recording are those of the first run only.
        wanted = replace(
            first, object=request.object_name, start=request.start_deg, planner=request.planner,
            seed=None, out=None, record=None,
        )  # fmt: skip
        if request.object_name != first.object:
            wanted = replace(wanted, data=None, up=None, height=None)
        try:
            return wanted, wanted.prepared(command)
        except CircumspectError as error:
            say(str(error))


def _latest(requests: Queue[RunRequest]) -> RunRequest:
    request = requests.get()
    while not requests.empty():
        request = requests.get_nowait()
    return request
