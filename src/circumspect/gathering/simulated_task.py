"""One simulated scan of a gathered set."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from circumspect.classification import Classifier
from circumspect.datasets.gathered_set import GatheredScan
from circumspect.errors import InputError
from circumspect.exploration.scan_settings import RoomSettings, ScanSettings
from circumspect.exploration.simulated_scan import SimulatedScan
from circumspect.gathering.gather_settings import GatherSettings
from circumspect.gathering.scan_files import scan_quality, write_scan
from circumspect.gathering.set_place import place_of
from circumspect.geometry import TriangleMesh
from circumspect.planning import SurfaceNormalPlanner
from circumspect.recognition import RecognitionResult
from circumspect.runs.run_path_log import RunPathLog

Measure = Callable[[SimulatedScan, RecognitionResult, RunPathLog], dict[str, Any]]
"""Measures a scan against the truth; JSON types."""


@dataclass(frozen=True, eq=False)
class SimulatedTask:
    """Everything that a process needs to make a scan.

    Attributes:
        scan: Its line in the manifest, without files and quality.
        mesh: The object [m].
        seed: Of room, slip and noise.
        settings: Of the set.
        place: Of the set, a path or URL.
        measure: Measures the scan against the simulation.
    """

    scan: GatheredScan
    mesh: TriangleMesh
    seed: int
    settings: GatherSettings
    place: str
    measure: Measure | None = None

    @property
    def key(self) -> str:
        """The scan's name."""
        return self.scan.scan


def scanned(job: SimulatedTask) -> dict[str, Any]:
    """Make a scan and write its files; the record says if the object cannot be scanned.

    Returns:
        Its `GatheredScan` in JSON types.

    Raises:
        InputError: This machine does not see the set.
        MissingExtraError: The simulator is not installed.
        OutputError: A file cannot be written.
    """
    with place_of(job.place).written() as folder:
        return _scanned(job, folder)


def _scanned(job: SimulatedTask, folder: Path) -> dict[str, Any]:
    scan, settings = job.scan, job.settings
    config = {"object": scan.object, "seed": job.seed, "start_deg": scan.start_deg}
    quality: dict[str, Any] = {"seed": job.seed}
    classifier = Classifier.load(threads=1)
    try:
        parts = SimulatedScan.prepared(
            job.mesh, RoomSettings(slip=settings.slip),
            ScanSettings(frame_interval=settings.frame_interval, max_frames=settings.frames),
            SurfaceNormalPlanner(), classifier, config,
        )  # fmt: skip
    except InputError as error:
        return asdict(replace(scan, quality={**quality, "ended": f"not begun: {error}"}))
    log, began = RunPathLog(parts.scan), time.process_time()
    result = parts.scan.run((log,))
    quality |= scan_quality(result)
    quality |= {"ended": parts.scan.ended, "distance_m": parts.scan.driven_m}
    quality["processor_s"] = round(time.process_time() - began, 2)
    if job.measure is not None:
        quality |= job.measure(parts, result, log)
    files = write_scan(folder, job.key, result, log.odometry)
    return asdict(replace(scan, files=files, quality=quality))
