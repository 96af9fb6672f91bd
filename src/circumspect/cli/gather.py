"""`circumspect gather`."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.given_flags import given_flags
from circumspect.cli.recording_flags import RecordingFlags
from circumspect.errors import InputError

if TYPE_CHECKING:
    from circumspect.datasets.gathered_set import GatheredScan
    from circumspect.exploration.simulated_scan import SimulatedScan
    from circumspect.gathering import GatherSettings
    from circumspect.recognition import RecognitionResult
    from circumspect.runs.run_path_log import RunPathLog

SHEET = "contact_sheet.png"


@dataclass(frozen=True)
class Gather:
    """A labelled set of scans: simulated, or from recordings of your own robot.

    $ circumspect gather --out gathered
    $ circumspect gather --classes chair table --train-objects 4 --out two
    $ circumspect gather --sources furniture ModelNet10 --train-objects 60 --out big
    $ circumspect gather --from run.mcap --label chair --name blue --out mine
    $ circumspect gather --from my.bag --depth-topic /d --label chair --out mine

    The same command goes on after an interruption, and adds what is new.
    """

    out: Annotated[str, tyro.conf.arg(metavar="DIR|URL")]
    """Folder of the set; `circumspect train --data OUT` trains on it, `circumspect data verify OUT`
    checks it. Simulated scans may also go to the URL of an object store, such as s3://bucket/set,
    which `circumspect data convert` reads."""
    classes: tuple[str, ...] = ("bed", "chair", "monitor", "sofa", "table", "toilet")
    """Classes of the objects."""
    train_objects: int = 8
    """Training objects of each class."""
    test_objects: int = 4
    """Test objects of each class; none of them is a training object."""
    train_starts: tuple[float, ...] = (0.0,)
    """Azimuths from which each training object is scanned [degrees]."""
    test_starts: tuple[float, ...] = (0.0, 45.0, 90.0, 135.0)
    """Azimuths from which each test object is scanned [degrees]."""
    sources: tuple[str, ...] = ("furniture",)
    """Objects are taken from these sources in turn: furniture (procedural), a folder with the
    layout of ModelNet10, or a mesh pack."""
    seed: int = 0
    """Of room, slip and noise."""
    slip: float = 0.05
    """Share of the wheels' travel that does not become motion."""
    frame_interval: float = 2.0
    """Time between two frames [s]."""
    frames: int = 1000
    """A scan ends after so many frames."""
    workers: int | None = None
    """Processes; one a core without it."""
    cluster: str | None = None
    """Scan on this Ray cluster: auto for the one that this machine belongs to, or HOST:PORT. All
    its nodes must see OUT."""
    from_: Annotated[Path | None, tyro.conf.arg(name="from", metavar="RECORDING")] = None
    """Add a recording, of any kind that `circumspect replay` takes, instead of simulating. Flags
    from --box on say how it is read, as they do there."""
    label: str | None = None
    """Of --from: the class of the object that it shows."""
    name: str | None = None
    """Of --from: the object's own name; all recordings of one object have the same. Without it
    that of the file."""
    split: Literal["train", "test"] | None = None
    """Of --from: what the object is for; without it what the set has it for, train where it is
    new."""
    start: float | None = None
    """Of --from: azimuth of the start [degrees], where you measured it."""
    replace: bool = False
    """Of --from: where the set holds the recording already, put it in the place of what is there,
    as after a wrong --label or --split, which its object's other scans then change, too."""
    json: bool = False
    """One JSON line at the end and nothing else on standard output."""
    reading: Annotated[RecordingFlags, tyro.conf.arg(name="")] = field(
        default_factory=RecordingFlags
    )
    """How a recording is read."""

    def run(self) -> int:
        """Scan, write, draw, tell."""
        scans = self._simulated() if self.from_ is None else self._recorded(self.from_)
        self._draw(scans)
        self._tell(scans)
        return 0

    def _simulated(self) -> list[GatheredScan]:
        from circumspect.cli.job_pool import opened_pool, seen_from
        from circumspect.cli.progress import progress_bar
        from circumspect.gathering import gather, objects_for
        from circumspect.gathering.set_place import place_of

        own = given_flags(self, "label", "name", "split", "start", "replace")
        if given := own + given_flags(self.reading):
            raise InputError(f"{given[0]} goes with --from RECORDING")
        settings = self._settings()
        with opened_pool(self.workers, self.cluster) as pool:
            with progress_bar("objects") as show:
                objects = objects_for(settings, show)
            with progress_bar(f"scans, {pool.name}") as show:
                return gather(
                    place_of(seen_from(self.cluster, self.out)), settings, objects, pool, measured,
                    lambda done, total, _: show(done, total),
                )  # fmt: skip

    def _settings(self) -> GatherSettings:
        from circumspect.gathering import GatherSettings

        return GatherSettings(
            self.classes, self.train_objects, self.test_objects, self.train_starts,
            self.test_starts, self.sources, self.seed, self.slip, self.frame_interval, self.frames,
        )  # fmt: skip

    def _recorded(self, recording: Path) -> list[GatheredScan]:
        from circumspect.classification import Classifier
        from circumspect.cli.say import say
        from circumspect.datasets.gathered_set import read_manifest
        from circumspect.gathering.recorded_scan import (
            RecordedObject,
            RecordedScan,
            recording_name,
        )

        if given := given_flags(
            self, "classes", "train_objects", "test_objects", "train_starts", "test_starts",
            "sources", "seed", "slip", "frame_interval", "frames", "workers", "cluster",
        ):  # fmt: skip
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
            scan.gather(opened.given(), pipeline, self.reading.told(), (screen,))
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

    def _tell(self, scans: list[GatheredScan]) -> None:
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
        print(_table(scans))  # noqa: T201
        held = "1 scan is" if len(scans) == 1 else f"{len(scans)} scans are"
        print(f"{held} in {self.out}; look at {self.out.rstrip('/')}/{SHEET}")  # noqa: T201
        if blind := sum("cloud" not in scan.files for scan in scans):
            told = f"{blind} of them never saw their object"
            print(f"{told}; circumspect data verify {self.out} names them")  # noqa: T201


def measured(
    parts: SimulatedScan, result: RecognitionResult, log: RunPathLog
) -> dict[str, float | None]:
    """What the simulation knows of a scan's quality."""
    from circumspect.evaluation.scan_error import scan_error
    from circumspect.runs.camera_path import camera_path

    last = result.last
    if last is None or last.grid is None:
        return {}
    error = scan_error(
        parts.witness.trajectory, camera_path(result), log.odometry,
        last.model.cloud().points_xyz, parts.room.scene, parts.camera,
    )  # fmt: skip
    told = error.summary()
    return {name: told[name] for name in ("ate_rmse_m", "chamfer_m", "completeness")}


def _table(scans: list[GatheredScan]) -> str:
    """Scans, named right and median error a class."""
    import numpy as np

    lines = [f"{'class':14}{'train':>8}{'test':>8}{'named right':>14}{'path [mm]':>12}"]
    for label in sorted({scan.label for scan in scans}):
        some = [scan for scan in scans if scan.label == label]
        right = sum(scan.quality.get("answer") == label for scan in some)
        errors = [scan.quality.get("ate_rmse_m") for scan in some]
        known = [error for error in errors if error is not None]
        path = f"{1e3 * np.median(known):.1f}" if known else "–"
        splits = [sum(scan.split == split for scan in some) for split in ("train", "test")]
        lines.append(
            f"{label:14}{splits[0]:8}{splits[1]:8}{f'{right} of {len(some)}':>14}{path:>12}"
        )
    return "\n".join(lines)
