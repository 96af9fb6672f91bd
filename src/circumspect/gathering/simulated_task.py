"""One simulated scan of a gathered set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from circumspect.classification import Classifier
from circumspect.datasets.gathered_set import GatheredScan
from circumspect.errors import InputError
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.exploration.simulated_scan import RoomSettings, SimulatedScan
from circumspect.furniture import make_furniture
from circumspect.gathering.gather_settings import GatherSettings, ScanTask
from circumspect.gathering.scan_files import told_quality, write_scan
from circumspect.planning import SurfaceNormalPlanner
from circumspect.recognition import RecognitionResult
from circumspect.runs.run_path_log import RunPathLog

Measure = Callable[[SimulatedScan, RecognitionResult, RunPathLog], dict[str, Any]]
"""Compares a scan with the truth; JSON types."""


@dataclass(frozen=True)
class SimulatedTask:
    """A task, and all that a process needs to do it.

    Attributes:
        task: Which scan.
        settings: Of the set.
        folder: Of the set.
        measure: What the simulation knows of the scan's quality.
    """

    task: ScanTask
    settings: GatherSettings
    folder: Path
    measure: Measure | None = None

    @property
    def key(self) -> str:
        """The scan's name."""
        return self.task.key


def scanned(job: SimulatedTask) -> dict[str, Any]:
    """Make a scan and write its files; an object that can not be scanned is told in the record.

    Returns:
        Its `GatheredScan` in JSON types.

    Raises:
        MissingExtraError: The simulator is not installed.
        OutputError: A file can not be written.
    """
    task, settings = job.task, job.settings
    seed = settings.seed_of(task)
    scan = GatheredScan(task.key, task.object, task.label, task.split, task.start_deg)
    config = {"object": task.object, "seed": seed, "start_deg": task.start_deg}
    quality: dict[str, Any] = {"seed": seed}
    classifier = Classifier.load(threads=1)
    try:
        parts = SimulatedScan.prepared(
            make_furniture(task.label, task.variant), RoomSettings(slip=settings.slip),
            ScanSettings(frame_interval=settings.frame_interval, most_frames=settings.frames),
            SurfaceNormalPlanner(), classifier, config,
        )  # fmt: skip
    except InputError as error:
        return asdict(replace(scan, quality={**quality, "ended": f"not begun: {error}"}))
    log = RunPathLog(parts.scan)
    result = parts.scan.run((log,))
    quality |= told_quality(result)
    quality |= {"ended": parts.scan.ended, "distance_m": parts.scan.driven_m}
    if job.measure is not None:
        quality |= job.measure(parts, result, log)
    files = write_scan(job.folder, task.key, result, log.odometry)
    return asdict(replace(scan, files=files, quality=quality))
