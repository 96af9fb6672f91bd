"""Snapshots of object models during simulated scans, at each coverage.

All classifiers can be evaluated on the same scans, because the path of the planner `normals` does
not depend on the answers.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.provenance import provenance
from benchmarks.scan_job import ScanJob, prepared
from circumspect.errors import CircumspectError
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.reconstruction import ObjectModel
from circumspect.storage import atomic_open

SHARES = (0.25, 0.5, 0.75, 1.0)
"""Coverages; a snapshot is taken at the first frame that reaches each."""


@dataclass(frozen=True)
class SnapshotJob:
    """A scan whose snapshots are stored.

    Attributes:
        job: The scan.
        folder: Folder of the snapshots.
    """

    job: ScanJob
    folder: str

    @property
    def key(self) -> str:
        """See `ScanJob.key`."""
        return self.job.key

    @property
    def path(self) -> Path:
        """File of the snapshots."""
        return Path(self.folder) / f"{self.key.replace('/', '_')}.npz"


class Snapshots:
    """Keeps the model of a run at each coverage; a `PipelineObserver`."""

    def __init__(self) -> None:
        self.kept: dict[str, NDArray[Any]] = {}

    def on_step(self, step: RecognitionStep) -> None:
        """See `PipelineObserver.on_step`."""
        if step.prediction is None:
            return
        for share in SHARES:
            if step.coverage >= share - 1e-9 and f"points_{share:g}" not in self.kept:
                self._keep(f"{share:g}", step.model.preview, step.coverage, step.index)

    def on_end(self, result: RecognitionResult) -> None:
        """See `PipelineObserver.on_end`."""
        last = result.last
        if last is not None and last.prediction is not None:
            self._keep("end", last.model, last.coverage, last.index)

    def _keep(self, name: str, model: ObjectModel, coverage: float, frame: int) -> None:
        cloud, rays = model.cloud(), model.rays
        self.kept |= {
            f"points_{name}": cloud.points_xyz.astype(np.float32),
            f"areas_{name}": np.asarray(cloud.weights, np.float32),
            f"origins_{name}": rays.origins_xyz,
            f"ends_{name}": rays.ends_xyz,
            f"coverage_{name}": np.array([coverage]),
            f"frame_{name}": np.array([frame]),
        }


def gather(job: SnapshotJob) -> dict[str, Any]:
    """Run a scan and store its snapshots; a known error becomes part of the record."""
    head = {"key": job.key, "made": provenance(), "suite": job.job.suite, "object": job.job.object}
    try:
        parts = prepared(job.job)
    except CircumspectError as error:
        return {**head, "true_label": None, "fault": str(error)}
    snapshots = Snapshots()
    parts.scan.run((snapshots,))
    with atomic_open(job.path, "wb") as stream:
        np.savez_compressed(stream, **snapshots.kept)  # pyright: ignore[reportArgumentType]
    return {**head, "true_label": parts.config["true_label"], "distance_m": parts.scan.driven_m}
