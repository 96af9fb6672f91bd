"""One simulated scan of the suite, and its figures."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.live_poses import LivePoses, reliability_figures
from benchmarks.provenance import provenance
from circumspect.classification import Classifier
from circumspect.classification.shipped import DEFAULT
from circumspect.errors import CircumspectError
from circumspect.evaluation.scan_error import ScanError, scan_error
from circumspect.exploration.scan_settings import RoomSettings, ScanSettings
from circumspect.exploration.simulated_scan import SimulatedScan
from circumspect.gathering.scanned_object import scanned_object
from circumspect.planning import (
    CirclePlanner,
    ConfidencePlanner,
    SurfaceNormalPlanner,
    ViewPlanner,
)
from circumspect.recognition import RecognitionResult
from circumspect.runs.run_folder import stage_lists, stage_times
from circumspect.runs.run_path import camera_path
from circumspect.runs.run_path_log import RunPathLog

PLANNERS = {
    "normals": SurfaceNormalPlanner,
    "circle": CirclePlanner,
    "confidence": ConfidencePlanner,
}
SLIP = 0.05
ROOM = RoomSettings(slip=SLIP)


@dataclass(frozen=True)
class ScanJob:
    """Object and settings of a scan.

    Attributes:
        suite: The table that the scan belongs to.
        object: Name of the object, as for `circumspect scan`.
        start_deg: Azimuth of the start.
        seed: Seed of room, slip and noise.
        planner: One of `PLANNERS`.
        frame_interval: Time between frames [s].
        frames: Maximum number of frames.
        data: Folder of the point packs, for their objects.
        detailed: Record the time of every stage of every frame; the network uses all cores.
        shape: Compare the model with the true surface, which takes half as long as the scan.
    """

    suite: str
    object: str
    start_deg: float
    seed: int
    planner: str = "normals"
    frame_interval: float = 0.5
    frames: int = 4000
    data: str | None = None
    detailed: bool = False
    shape: bool = True

    @property
    def key(self) -> str:
        """Unique name."""
        what = f"{self.suite}/{self.object}/{self.start_deg:g}/{self.seed}/{self.planner}"
        return f"{what}/{self.frame_interval:g}/{self.frames}"


def prepared(
    job: ScanJob, planner: ViewPlanner | None = None, world: RoomSettings = ROOM
) -> SimulatedScan:
    """The scan of a job, ready to run."""
    scanned = scanned_object(job.object, 0, data=None if job.data is None else Path(job.data))
    config = {
        "object": scanned.name, "true_label": scanned.label, "truth": scanned.label,
        "seed": job.seed, "start_deg": job.start_deg, "planner": job.planner,
    }  # fmt: skip
    driving = ScanSettings(frame_interval=job.frame_interval, max_frames=job.frames)
    return SimulatedScan.prepared(
        scanned.mesh, world, driving, planner or PLANNERS[job.planner](),
        # For timing, nothing else runs, and the network uses all cores, as by default.
        Classifier.load(threads=0 if job.detailed else 1), config,
    )  # fmt: skip


def run_job(job: ScanJob) -> dict[str, Any]:
    """Run and evaluate a scan; a known error becomes part of the record.

    Returns:
        JSON types: the job, its key and its figures.
    """
    head = {"key": job.key, "made": provenance(), "model": DEFAULT, **asdict(job)}
    # The folder of the data depends on the machine.
    del head["data"]
    try:
        parts = prepared(job)
    except CircumspectError as error:
        return {**head, "label": None, "ended": f"not begun: {error}", "frames": 0}
    log = RunPathLog(parts.scan)
    live = LivePoses()
    result = parts.scan.run((log, live))
    error, plan = measured(parts, result, log, job.shape), parts.scan.plan_milliseconds
    return {
        **head,
        "true_label": parts.config["true_label"],
        **answer_figures(result),
        "ended": parts.scan.ended,
        "distance_m": parts.scan.driven_m,
        **settled(result, log),
        **error.summary(),
        **reliability_figures(live.estimates, parts.ground_truth.trajectory)._asdict(),
        "missing": list(error.missing),
        "views": dict(Counter(record.reason for record in parts.scan.views)),
        "milliseconds": stage_times(result.steps, plan),
        **({"stages": stage_lists(result.steps, plan)} if job.detailed else {}),
    }


def measured(
    parts: SimulatedScan, result: RecognitionResult, log: RunPathLog, shape: bool = True
) -> ScanError:
    """Errors of the scan compared with the truth."""
    return scan_error(
        parts.ground_truth.trajectory, camera_path(result), log.odometry,
        result.points_xyz if shape else None, parts.room.scene, parts.camera,
    )  # fmt: skip


def answer_figures(result: RecognitionResult) -> dict[str, Any]:
    """Figures of the pipeline's answer."""
    prediction, last = result.prediction, result.last
    states = Counter(step.pose.state for step in result.steps if step.pose is not None)
    return {
        "label": None if prediction is None else prediction.label,
        "probability": None if prediction is None else prediction.probability,
        "in_distribution": None if prediction is None else prediction.in_distribution,
        "confident": result.confident,
        "frames": len(result.steps),
        "coverage": 0.0 if last is None else last.coverage,
        "outcomes": dict(Counter(step.outcome for step in result.steps)),
        "states": dict(states),
    }


def settled(result: RecognitionResult, log: RunPathLog) -> dict[str, float | None]:
    """Distance [m] and frame from which on the label did not change."""
    labels = [None if s.prediction is None else s.prediction.label for s in result.steps]
    driven = log.run_path(result).driven_by(np.array([step.stamp for step in result.steps]))
    if not labels or labels[-1] is None or driven is None:
        return {"settled_m": None, "settled_frame": None}
    back = next((k for k in count(1) if k == len(labels) or labels[-k - 1] != labels[-1]), 1)
    first = len(labels) - back
    return {"settled_m": float(driven[first]), "settled_frame": first}
