"""`circumspect scan OBJECT`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.given_flags import flags_named
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.errors import InputError

if TYPE_CHECKING:
    from circumspect.cli.scan_report import ScanReport
    from circumspect.cli.scan_space import ScanSpace
    from circumspect.cli.watched_scan import ScanWatch
    from circumspect.exploration.scan_settings import ScanSettings
    from circumspect.exploration.simulated_scan import SimulatedScan
    from circumspect.planning import ViewPlanner
    from circumspect.recording import RunRecorder

UNITS = "are its units metres?"
"""How a fault ends that a mesh of another size would not have."""


@dataclass(frozen=True)
class Scan:
    """A simulated robot drives round an object, models it and names it.

    $ circumspect scan chair
    $ circumspect scan sofa-17 --start 135 --slip 0.1 --planner confidence
    $ circumspect scan desk.obj --up y --height 0.75 --stop-when-sure
    $ circumspect scan chair_0890 --data modelnet10 --json
    $ circumspect scan toilet --record toilet.mcap
    $ circumspect scan table --space
    $ circumspect scan sofa --viewer
    """

    object: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="OBJECT")]
    """bathtub, bed, chair, desk, dresser, monitor, night_stand, sofa, table or toilet; one of them
    with a variant, chair-17; a mesh file; or with --data the name of an object there."""
    start: float | None = None
    """Azimuth of the start [degrees], counter-clockwise seen from above; without it drawn."""
    seed: int | None = None
    """The same seed gives the same run; without it a new one is drawn."""
    planner: Annotated[str, tyro.conf.arg(metavar="NAME|MODULE:NAME")] = "normals"
    """Where to look from next: normals, along the surface's normals as in the paper; circle;
    confidence, on a circle until the answer is confident; or a planner of your own, by the name
    that its package gives it or by MODULE:NAME."""
    stop_when_sure: bool = False
    """End as soon as the answer is confident in three consecutive frames, whatever the planner."""
    slip: float = 0.05
    """Share of the wheels' travel that does not become motion, 0 to 0.5."""
    wheel_error: float = 0.0
    """Share by which the right wheel is larger than the odometry believes, -0.2 to 0.2."""
    bumps: float = 0.0
    """Height of the highest ridge on the floor [m], 0 to 0.05."""
    speed: float = 0.05
    """The robot's speed [m/s], 0.01 to 1."""
    frame_interval: float = 0.5
    """Time between two frames [s], 0.1 to 60."""
    frames: int = 4000
    """The scan ends after so many frames."""
    clutter: bool = True
    """Put nothing else into the room; without it other things stand about."""
    mast_height: float = 1.2
    """Height of the camera above the floor [m], 0.05 to 5."""
    tilt: float | None = None
    """How far the camera looks down [degrees]; without it so that the object is in view."""
    real_time: bool = False
    """Go no faster than a real robot; without it as fast as the machine can."""
    space: bool = False
    """Four ceiling cameras see a tag on the robot, too, and the run is compared with what they
    say; the robot hears nothing of it."""
    data: Path | None = None
    """ModelNet10's folder of point packs, or that of OFF files, which `circumspect data fetch`
    makes; OBJECT is the name of an object in it."""
    up: Literal["x", "y", "z"] | None = None
    """The axis that points up in a mesh file; by default y for glTF/GLB, what the file says for
    USD, and z for all others."""
    height: float | None = None
    """Scale a mesh file to this height [m]; without it its unit is taken for a metre."""
    model: ModelFlag = ROBOT
    """A shipped classifier (`circumspect models` lists them), or an ONNX file of your own that
    `circumspect export` made."""
    out: Path | None = None
    """Folder of the run; runs/scan-DATE-TIME by default. An earlier run there is replaced."""
    record: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Record what the robot and the ceiling cameras see into a new MCAP file, and the answers;
    `circumspect replay`, Foxglove and ROS 2 can play it."""
    viewer: bool = False
    """Show the run in the browser, where it can be steered; the page stays when the run is over."""
    page: Annotated[PageFlags, tyro.conf.arg(name="")] = field(default_factory=PageFlags)
    """Where the dashboard is shown."""
    json: bool = False
    """One JSON line on standard output and nothing else there."""

    def run(self, command: str = "scan") -> int:
        """Drive, model, name, save.

        Args:
            command: What the run's folder is named after.
        """
        if self.viewer:
            from circumspect.cli.watched_scan import watched_scans

            return watched_scans(self, command)
        return self.scan(self.prepared(command), command)

    def scan(self, parts: SimulatedScan, command: str, watch: ScanWatch | None = None) -> int:
        """One run, from start to report.

        Args:
            parts: What `prepared` made.
            command: What the run's folder is named after.
            watch: Shows and steers it, where wanted.

        Returns:
            Exit code: 0, or `NO_ANSWER`.
        """
        from circumspect.cli.run_screen import NO_ANSWER, RunScreen
        from circumspect.runs.step_recorder import StepRecorder

        scan, recorder = self._recorded(parts if watch is None else watch.operated(parts))
        try:
            report = self._reported(scan, recorder, command)
        except BaseException:
            # Whoever stops a run before it begins can give the same command again.
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
        report.tell(result, self.json, screen.label)
        if recorder is not None and recorder.failure is not None:
            raise recorder.failure
        return NO_ANSWER if result.prediction is None else 0

    def _reported(
        self, scan: SimulatedScan, recorder: RunRecorder | None, command: str
    ) -> ScanReport:
        """The run's folder, and the ceiling cameras where they are asked for."""
        from circumspect.cli.run_screen import new_run_folder
        from circumspect.cli.scan_report import ScanReport

        space = self._watched(scan)
        if space is not None and recorder is not None:
            space.record(recorder)
        return ScanReport(scan, self.out or new_run_folder(command), space)

    def _recorded(self, scan: SimulatedScan) -> tuple[SimulatedScan, RunRecorder | None]:
        """The scan, with a recorder where one is asked for."""
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
        """Everything that can be wrong with the flags is told here, before anything is written."""
        import numpy as np

        from circumspect import __version__
        from circumspect.classification import Classifier
        from circumspect.cli.model_record import model_record
        from circumspect.exploration.simulated_scan import RoomSettings, SimulatedScan
        from circumspect.gathering.scanned_object import scanned_object

        seed = drawn_seed(self.seed)
        # All chance is drawn in any case, so that a given flag does not change the others.
        rng = np.random.default_rng(seed)
        variant, start_deg = int(rng.integers(1000)), float(np.round(rng.uniform(0, 360), 1))
        if self.start is not None:
            start_deg = self.start
        if not np.isfinite(start_deg):
            raise InputError(f"--start {start_deg}: give degrees")
        thing = scanned_object(self.object, variant, self.up, self.height, self.data)
        config = {
            "command": command,
            "version": __version__,
            "object": thing.name,
            "true_label": thing.label,
            "truth": thing.label,
            "seed": seed,
            "start_deg": start_deg,
            "planner": self.planner,
            "stop_when_sure": self.stop_when_sure,
            "data": None if self.data is None else str(self.data),
            "up": self.up,
            "height": self.height,
        }
        world = RoomSettings(
            self.slip, self.clutter, self.mast_height, self.tilt, self.wheel_error, self.bumps
        )
        classifier = Classifier.load(self.model)
        config["classifier"] = model_record(self.model)
        checked = ("slip", "wheel_error", "bumps", "speed", "frame_interval", "mast_height", "tilt")
        try:
            with flags_named(self, *checked):
                return SimulatedScan.prepared(
                    thing.mesh, world, self._settings(), self._planner(), classifier, config,
                    colour=self.viewer, real_time=self.real_time,
                )  # fmt: skip
        except InputError as error:
            # Where the object does not fit the camera it is asked for its units.
            if not str(error).endswith(UNITS):
                raise
            raise InputError(f"{error} --height scales it to a height in metres") from error

    def _watched(self, scan: SimulatedScan) -> ScanSpace | None:
        if not self.space:
            return None
        from circumspect.cli.scan_space import ScanSpace

        return ScanSpace(scan)

    def _settings(self) -> ScanSettings:
        from circumspect.exploration.scan_settings import ScanSettings

        if self.frames < 1:
            raise InputError(f"--frames {self.frames}: at least one frame is needed")
        return ScanSettings(
            speed=self.speed, frame_interval=self.frame_interval, most_frames=self.frames
        )

    def _planner(self) -> ViewPlanner:
        from circumspect.planning import ConfidencePlanner, make_planner

        planner = make_planner(self.planner)
        if self.stop_when_sure and not isinstance(planner, ConfidencePlanner):
            return ConfidencePlanner(planner)
        return planner


def _how_to_repeat(config: Mapping[str, Any], chosen_there: bool) -> str:
    """How to have a run again; what nobody gave was drawn.

    Args:
        config: Of the run.
        chosen_there: Object, start and planner may have been chosen on the page.
    """
    if not chosen_there:
        return f"the same command with --seed {config['seed']} starts the same run again"
    return (
        f"circumspect scan {config['object']} --start {config['start_deg']} --seed {config['seed']}"
        f" --planner {config['planner']} --frame-interval {config['scan']['frame_interval']} and "
        "the other flags start the same run again"
    )


def drawn_seed(given: int | None) -> int:
    """The seed that was given, or a new one.

    Raises:
        InputError: A negative one.
    """
    import numpy as np

    if given is not None and given < 0:
        raise InputError(f"--seed {given}: give a whole number of at least 0")
    return int(np.random.default_rng().integers(2**31)) if given is None else given
