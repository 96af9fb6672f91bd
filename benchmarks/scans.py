"""Scans of a simulated robot: trajectory, shape, answer, distance, time and memory.

    python -m benchmarks.scans                            # all suites; hours
    python -m benchmarks.scans --suite furniture --each 6
    python -m benchmarks.scans --tables                   # only from existing records

Each scan is one JSON line in `benchmarks/results/scans.jsonl`. Existing scans are not repeated, so
that an interrupted run resumes. The tables cover the scans of all suites with the same settings.
`docs/scans.md` explains the figures.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.report import RESULTS, progress_report
from benchmarks.scan_job import PLANNERS, ScanJob, run_job
from benchmarks.scan_tables import write_tables
from benchmarks.selection import command_with_flags, records_of_jobs
from circumspect.datasets.point_pack import read_point_pack
from circumspect.furniture import CATEGORIES
from circumspect.gathering.job_pool import LocalPool, records, run_all

SUITES = ("furniture", "planners", "modelnet", "timing")
SETTINGS = ("each", "objects", "frame_interval")
"""Flags that determine the scans."""
STARTS_DEG = tuple(np.arange(8) * 45.0)
DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "modelnet10"
FIRST_VARIANT = 100_000
"""First variant of the furniture; no other benchmark uses these variants."""


def main() -> int:
    """Run the requested suites and write the tables."""
    arguments, defaults = _parser().parse_args(), _parser().parse_args([])
    path: Path = arguments.out / "scans.jsonl"
    if not arguments.tables:
        for suite in arguments.suite or SUITES:
            # Times are valid only if nothing else runs.
            workers = 1 if suite == "timing" else arguments.workers
            run_all(jobs(suite, arguments), run_job, path, LocalPool(workers), progress_report())
    command = command_with_flags("python -m benchmarks.scans", arguments, defaults, SETTINGS)
    write_tables(selected(records(path), arguments), arguments.out, command, arguments.data)
    return 0


def selected(found: list[dict[str, Any]], arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """The records of the given settings, of all suites with records."""
    there = {record["suite"] for record in found}
    wanted = [job for suite in SUITES if suite in there for job in jobs(suite, arguments)]
    return records_of_jobs(found, wanted)


def jobs(suite: str, arguments: argparse.Namespace) -> list[ScanJob]:
    """All scans of a suite; the same arguments give the same scans."""
    each = arguments.each
    if suite == "furniture":
        return furniture_jobs(each)
    if suite == "planners":
        some = range(max(1, each // 3))
        every = arguments.frame_interval
        return [j for p in PLANNERS for number in some for j in _round(suite, number, p, every)]
    if suite == "timing":
        return _round(suite, 0, detailed=True)
    return _modelnet(arguments.data, arguments.objects, arguments.frame_interval)


def furniture_jobs(each: int) -> list[ScanJob]:
    """`each` scans of every furniture category."""
    return [job for number in range(each) for job in _round("furniture", number)]


def _round(
    suite: str,
    number: int,
    planner: str = "normals",
    frame_interval: float = 0.5,
    detailed: bool = False,
) -> list[ScanJob]:
    """One scan of each category, each from its own start."""
    found = []
    for index, category in enumerate(CATEGORIES):
        rng = np.random.default_rng([number, index])
        start, seed = float(np.round(rng.uniform(0, 360), 1)), int(rng.integers(2**31))
        name = f"{category}-{FIRST_VARIANT + number}"
        found.append(ScanJob(suite, name, start, seed, planner, frame_interval, detailed=detailed))
    return found


def _modelnet(data: Path, objects: int, frame_interval: float) -> list[ScanJob]:
    """Evenly chosen test objects of each class, each from eight starts."""
    pack = read_point_pack(data / "test.npz")
    found = []
    for label in range(len(pack.classes)):
        members = np.flatnonzero(pack.labels == label)
        chosen = members[np.linspace(0, len(members) - 1, min(objects, len(members))).astype(int)]
        for index in chosen:
            seed = int(np.random.default_rng([label, int(index)]).integers(2**31))
            found += [
                ScanJob(
                    "modelnet", str(pack.names[index]), start, seed, "normals", frame_interval,
                    data=os.fspath(data), shape=False,
                )
                for start in STARTS_DEG
            ]  # fmt: skip
    return found


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--suite", choices=SUITES, action="append", help="default: all suites")
    parser.add_argument("--each", type=int, default=6, help="scans a category (furniture)")
    parser.add_argument("--objects", type=int, default=3, help="objects a class (modelnet)")
    parser.add_argument(
        "--frame-interval", type=float, default=2.0, help="between frames [s] (planners, modelnet)"
    )
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the point packs")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument("--tables", action="store_true", help="only write the tables")
    return parser


if __name__ == "__main__":
    sys.exit(main())
