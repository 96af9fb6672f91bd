"""`circumspect gather`."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.config_file import ConfigFlag, write_config
from circumspect.cli.flag_table import Flags
from circumspect.cli.given_flags import given_flags
from circumspect.cli.recording_flags import RecordingFlags
from circumspect.errors import InputError
from circumspect.gathering.gather_settings import GatherSettings

if TYPE_CHECKING:
    from rich.table import Table

    from circumspect.datasets.gathered_set import GatheredScan
    from circumspect.exploration.simulated_scan import SimulatedScan
    from circumspect.recognition import RecognitionResult
    from circumspect.runs.run_path_log import RunPathLog

SHEET = "contact_sheet.png"


@dataclass(frozen=True)
class Gather:
    """Make a labelled set of scans, simulated or from recordings of your own robot.

    $ circumspect gather --out gathered
    $ circumspect gather --classes chair table --train-objects 4 --out two
    $ circumspect gather --sources furniture ModelNet10 --train-objects 60 --out big
    $ circumspect gather --from run.mcap --label chair --name blue --out mine
    $ circumspect gather --from my.bag --depth-topic /d --label chair --out mine

    The same command resumes after an interruption, and adds new scans.
    """

    out: Annotated[str, tyro.conf.arg(metavar="DIR|URL")]
    """Folder of the set; `circumspect train --data OUT` trains on it, `circumspect data verify OUT`
    checks it. Simulated scans may also be written to the URL of an object store, such as
    s3://bucket/set, which `circumspect data convert` reads."""
    settings: Annotated[
        GatherSettings,
        Flags.every(train_starts_deg="train_starts", test_starts_deg="test_starts"),
    ] = field(default_factory=GatherSettings)
    """Objects and scans of the set."""
    workers: int | None = None
    """Number of processes; one per core by default."""
    cluster: str | None = None
    """Ray cluster that makes the scans: auto for the cluster of this machine, or HOST:PORT. All its
    nodes must have access to OUT."""
    from_: Annotated[Path | None, tyro.conf.arg(metavar="RECORDING")] = None
    """Add a recording instead of simulated scans. Formats, and the flags from --box on, are those
    of `circumspect replay`."""
    label: str | None = None
    """With --from: class of the recorded object."""
    name: str | None = None
    """With --from: name of the object, the same for all its recordings; by default that of the
    file."""
    split: Literal["train", "test"] | None = None
    """With --from: split of the object. By default the split that it has in the set, train for a
    new object."""
    start: float | None = None
    """With --from: azimuth of the start [degrees], if measured."""
    replace: bool = False
    """With --from: replace the recording if it is already in the set, for example after a wrong
    --label or --split. The object's other scans get the new label and split, too."""
    json: bool = False
    """Print one JSON line at the end on standard output and nothing else."""
    reading: RecordingFlags = field(default_factory=RecordingFlags)
    """How to read a recording."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Scan, write the set, draw the contact sheet and print a table."""
        scans = self._simulated() if self.from_ is None else self._recorded(self.from_)
        self._draw(scans)
        self._print(scans)
        return 0

    def _simulated(self) -> list[GatheredScan]:
        from circumspect.cli.job_pool import opened_pool, seen_from
        from circumspect.cli.progress import progress_bar
        from circumspect.gathering.gather import gather, objects_for
        from circumspect.gathering.set_place import place_of

        if given := given_flags(self, "label", "name", "split", "start", "replace", "reading"):
            raise InputError(f"{given[0]} goes with --from RECORDING")
        place = place_of(seen_from(self.cluster, self.out))
        with opened_pool(self.workers, self.cluster) as pool:
            with progress_bar("objects") as show:
                objects = objects_for(self.settings, show)
            with progress_bar(f"scans, {pool.name}") as show:

                def report(done: int, total: int, scan: str) -> None:
                    if not scan:  # The set exists, and no scan is made yet.
                        with place.written() as folder:
                            write_config(folder, self, "gather")
                    show(done, total)

                return gather(place, self.settings, objects, pool, measured, report)

    def _recorded(self, recording: Path) -> list[GatheredScan]:
        from circumspect.classification import Classifier
        from circumspect.cli.say import say
        from circumspect.datasets.gathered_set import read_manifest
        from circumspect.gathering.recorded_scan import (
            RecordedObject,
            RecordedScan,
            recording_name,
        )

        if given := given_flags(self, "settings", "workers", "cluster"):
            raise InputError(f"{given[0]} is for simulated scans; --from RECORDING has its own")
        if self.label is None:
            raise InputError("--from RECORDING needs the --label of what it shows")
        if "://" in self.out:
            raise InputError(f"--out {self.out}: recordings are added to sets in folders")
        out = Path(self.out)
        shown = RecordedObject(
            self.label, self.name or recording_name(recording), self.split, self.start
        )
        scan = RecordedScan(out, recording, shown, self.replace)
        opened = self.reading.opened(recording)
        pipeline = opened.pipeline(Classifier.load())
        with opened.screen() as screen:
            scan.gather(opened.given(), pipeline, self.reading.changed(), (screen,))
        write_config(out, self, "gather")
        if scan.changed:
            names, was = ", ".join(one.scan for one in scan.changed), scan.changed[0]
            say(
                f"{names}: {self.label} of the {scan.split} split now, was {was.label} of the "
                f"{was.split} split"
            )
        return read_manifest(out)

    def _draw(self, scans: list[GatheredScan]) -> None:
        from circumspect.gathering.contact_sheet import draw_contact_sheet, shown_scans
        from circumspect.gathering.set_place import place_of

        place, shown = place_of(self.out), shown_scans(scans)
        with place.local(shown) as folder, place.written() as beside:
            draw_contact_sheet(beside / SHEET, folder, shown)

    def _print(self, scans: list[GatheredScan]) -> None:
        if self.json:
            counts = Counter(f"{scan.split}/{scan.label}" for scan in scans)
            document: dict[str, Any] = {
                "folder": self.out,
                "scans": len(scans),
                "counts": dict(sorted(counts.items())),
                "without_cloud": [scan.scan for scan in scans if "cloud" not in scan.files],
            }
            print(json.dumps(document))  # noqa: T201
            return
        from circumspect.cli.console import show

        show(_table(scans))
        held = "1 scan is" if len(scans) == 1 else f"{len(scans)} scans are"
        print(f"{held} in {self.out}; look at {self.out.rstrip('/')}/{SHEET}")  # noqa: T201
        if blind := sum("cloud" not in scan.files for scan in scans):
            text = f"{blind} of them never saw their object"
            print(f"{text}; circumspect data verify {self.out} names them")  # noqa: T201


def measured(
    parts: SimulatedScan, result: RecognitionResult, log: RunPathLog
) -> dict[str, float | None]:
    """Errors of a scan against the ground truth of the simulation."""
    from circumspect.evaluation.scan_error import scan_error
    from circumspect.runs.run_path import camera_path

    last = result.last
    if last is None or last.grid is None:
        return {}
    error = scan_error(
        parts.ground_truth.trajectory, camera_path(result), log.odometry,
        last.model.cloud().points_xyz, parts.room.scene, parts.camera,
    )  # fmt: skip
    summary = error.summary()
    return {name: summary[name] for name in ("ate_rmse_m", "chamfer_m", "completeness")}


def _table(scans: list[GatheredScan]) -> Table:
    """Scans, correct answers and median error of each class."""
    import numpy as np
    from rich.text import Text

    from circumspect.cli.console import new_table

    table = new_table(["class"], ["train", "test", "correct", "path [mm]"])
    for label in sorted({scan.label for scan in scans}):
        some = [scan for scan in scans if scan.label == label]
        right = sum(scan.quality.get("answer") == label for scan in some)
        errors = [scan.quality.get("ate_rmse_m") for scan in some]
        known = [error for error in errors if error is not None]
        path = f"{1e3 * np.median(known):.1f}" if known else "–"
        splits = [sum(scan.split == split for scan in some) for split in ("train", "test")]
        table.add_row(Text(label), str(splits[0]), str(splits[1]), f"{right} of {len(some)}", path)
    return table
