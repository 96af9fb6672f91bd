"""Error of the tracker by distance limit and voxel size.

    python -m benchmarks.depth_limits --data DIR   # minutes, including the simulated scan

Real recordings and frames of a simulated camera with distorted depth are tracked without odometry,
with the complete measurement model and with white noise only. Each run is one JSON line in
`runs/depth_limits.jsonl` and is not repeated.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from scipy.spatial.transform import RigidTransform

from benchmarks.ablation import DATA
from benchmarks.ablation_data import Source, loaded, real
from benchmarks.ablation_rules import RULES
from benchmarks.fault_scenarios import FaultJob, prepared_fault
from benchmarks.open_loop import run_open_loop
from benchmarks.open_loop_trackers import OwnTracker
from benchmarks.provenance import made_by, provenance
from benchmarks.recorded_scans import FOLDER, FrameRecorder, read, write
from benchmarks.report import RESULTS, progress_report, write_page
from benchmarks.rule_patches import without
from benchmarks.scan_job import ScanJob
from circumspect.evaluation.markdown import table
from circumspect.gathering.job_pool import LocalPool, records, run_all
from circumspect.sensing import RgbdFrame
from circumspect.tracking import TrackingSettings

NAME = "depth_limits"
RECORDS = f"{NAME}.jsonl"
SIMULATED = "simulated camera"
SCAN = FaultJob(
    "camera with depth distortion", ScanJob(NAME, "chair-100070", 30.0, 0, "normals", 0.1, 300)
)
"""A variant that no other benchmark uses, at ten frames per second."""
DEPTHS_M, VOXELS_M = (1.6, 2.0, 2.5, 3.0, 3.5, 4.0), (0.01, 0.02, 0.03, 0.04)
DEFAULT_DEPTH_M, DEFAULT_VOXEL_M = 2.5, 0.03
MODEL, WHITE = "model", "white noise"
"""The complete measurement model, and the model without systematic errors."""
SYSTEMATIC = ("systematic errors", "systematic slopes", "spurious information")


@dataclass(frozen=True)
class DepthJob:
    """A recording with settings.

    Attributes:
        source: A real recording; None for the simulated camera.
        variant: `MODEL` or `WHITE`.
        max_depth, voxel: [m].
    """

    source: Source | None
    variant: str
    max_depth: float = DEFAULT_DEPTH_M
    voxel: float = DEFAULT_VOXEL_M

    @property
    def recording(self) -> str:
        """Name of the recording."""
        return SIMULATED if self.source is None else self.source.name

    @property
    def key(self) -> str:
        """Unique name."""
        what = SIMULATED if self.source is None else self.source.key
        return f"{what}/{self.variant}/{self.max_depth:g}/{self.voxel:g}"


def jobs(sources: Sequence[Source | None]) -> list[DepthJob]:
    """Every distance at the default voxel size, and every voxel size at the default distance."""
    limits = [(depth, DEFAULT_VOXEL_M) for depth in DEPTHS_M]
    limits += [(DEFAULT_DEPTH_M, voxel) for voxel in VOXELS_M if voxel != DEFAULT_VOXEL_M]
    return [
        DepthJob(source, variant, *limit)
        for source in sources
        for variant in (MODEL, WHITE)
        for limit in limits
    ]


def run(job: DepthJob) -> dict[str, Any]:
    """Track a recording."""
    frames, truth = _simulated() if job.source is None else loaded(job.source)
    settings = TrackingSettings()
    settings = replace(
        settings, scan=replace(settings.scan, max_depth=job.max_depth, voxel=job.voxel)
    )
    with _variant(job.variant):
        result = run_open_loop(OwnTracker(settings), frames, truth)
    return {
        "key": job.key, "made": provenance(), "recording": job.recording, "variant": job.variant,
        "max_depth_m": job.max_depth, "voxel_m": job.voxel, **result.as_dict(),
    }  # fmt: skip


def _variant(name: str) -> ExitStack:
    off = SYSTEMATIC if name == WHITE else ()
    return without([rule for rule in RULES if rule.name in off])


def _simulated() -> tuple[Sequence[RgbdFrame], RigidTransform]:
    """Frames of the simulated camera without odometry; only the first has a pose."""
    scan = read(_path())
    bare = [replace(frame, odometry=None, T_base_camera=None) for frame in scan.frames]
    return [replace(bare[0], T_map_camera=scan.truth[0]), *bare[1:]], scan.truth


def _path() -> Path:
    return FOLDER.parent / NAME / "simulated.npz"


def record() -> None:
    """Record the simulated scan if its file does not exist."""
    if _path().exists():
        return
    parts = prepared_fault(SCAN)
    recorder = FrameRecorder(parts.scan.robot, parts.ground_truth)
    parts.driven_by(recorder).scan.run()
    _path().parent.mkdir(parents=True, exist_ok=True)
    write(_path(), recorder.frames)


def page(found: Sequence[Mapping[str, Any]]) -> str:
    """A table over the distances, and one over the voxel sizes."""
    by_depth = [r for r in found if r["voxel_m"] == DEFAULT_VOXEL_M]
    by_voxel = [r for r in found if r["max_depth_m"] == DEFAULT_DEPTH_M]
    return "\n\n".join([
        "ATE of live poses [mm], and the largest value as a multiple of the smallest.",
        f"Limits of the depth, with voxels of {100 * DEFAULT_VOXEL_M:g} cm:",
        _table(by_depth, "max_depth_m", DEPTHS_M, "{:g} m"),
        f"Voxel sizes, with depths up to {DEFAULT_DEPTH_M:g} m:",
        _table(by_voxel, "voxel_m", VOXELS_M, "{:g} cm", 100),
    ])  # fmt: skip


def _table(
    found: Sequence[Mapping[str, Any]],
    name: str,
    values: Sequence[float],
    form: str,
    factor: float = 1.0,
) -> str:
    rows = []
    for recording, variant in dict.fromkeys((r["recording"], r["variant"]) for r in found):
        of_row = {
            r[name]: r["ate_mm"]
            for r in found
            if (r["recording"], r["variant"]) == (recording, variant)
        }
        errors = [of_row[value] for value in values]
        spread = f"{max(errors) / min(errors):.2f}"
        rows.append([recording, variant, *(f"{error:.1f}" for error in errors), spread])
    head = ["recording", "noise model", *(form.format(factor * v) for v in values), "max / min"]
    return table(head, rows)


def main() -> int:
    """Run missing settings and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=DATA, help="folder of real recordings")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    record()
    wanted = jobs([None, *real(given.data, None)])
    path = FOLDER.parent / RECORDS
    run_all(wanted, run, path, LocalPool(given.workers), progress_report())
    by_key = {record["key"]: record for record in records(path)}
    found = [by_key[job.key] for job in wanted]
    write_page(
        NAME, "Distance limits and voxel sizes", f"python -m benchmarks.{NAME}",
        f"{made_by(found)}\n\n{page(found)}", {"runs": found}, given.out,
    )  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
