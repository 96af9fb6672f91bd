"""Scans of a simulated robot: trajectory, shape, answer, distance, time and memory.

    python -m benchmarks.scans                            # all suites; hours
    python -m benchmarks.scans --suite furniture --each 6
    python -m benchmarks.scans --tables                   # only from what is there

Every scan is one JSON line in `benchmarks/results/scans.jsonl`; scans that are there already are
not done again, so an interrupted run resumes. The tables are of all suites, and of the
scans in them that the same settings make. `docs/scans.md` says what it all means.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.asked import command_with, of_jobs
from benchmarks.report import RESULTS, progress_report
from benchmarks.scan_job import PLANNERS, ScanJob, run_job
from benchmarks.scan_tables import write_tables
from circumspect.datasets.point_pack import read_point_pack
from circumspect.furniture import CATEGORIES
from circumspect.gathering.job_pool import LocalPool, records, run_all

SUITES = ("furniture", "planners", "modelnet", "timing")
SETTINGS = ("each", "objects", "frame_interval")
"""Flags that say which scans there are."""
STARTS_DEG = tuple(np.arange(8) * 45.0)
DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "modelnet10"
FIRST_VARIANT = 100_000
"""Of the furniture: variants that nothing else uses."""


def main() -> int:
    """Run the suites that are asked for and write the tables."""
    arguments, usual = _parser().parse_args(), _parser().parse_args([])
    path: Path = arguments.out / "scans.jsonl"
    if not arguments.tables:
        for suite in arguments.suite or SUITES:
            # Times are only worth something when nothing else runs.
            workers = 1 if suite == "timing" else arguments.workers
            run_all(jobs(suite, arguments), run_job, path, LocalPool(workers), progress_report())
    command = command_with("python -m benchmarks.scans", arguments, usual, SETTINGS)
    write_tables(asked(records(path), arguments), arguments.out, command, arguments.data)
    return 0


def asked(found: list[dict[str, Any]], arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """The records of the settings asked for, of all suites that there are records of."""
    there = {record["suite"] for record in found}
    wanted = [job for suite in SUITES if suite in there for job in jobs(suite, arguments)]
    return of_jobs(found, wanted)


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
    """So many scans of every furniture category."""
    return [job for number in range(each) for job in _round("furniture", number)]


def _round(
    suite: str,
    number: int,
    planner: str = "normals",
    frame_interval: float = 0.5,
    detailed: bool = False,
) -> list[ScanJob]:
    """One scan of each category, from a start of its own."""
    found = []
    for index, category in enumerate(CATEGORIES):
        rng = np.random.default_rng([number, index])
        start, seed = float(np.round(rng.uniform(0, 360), 1)), int(rng.integers(2**31))
        name = f"{category}-{FIRST_VARIANT + number}"
        found.append(ScanJob(suite, name, start, seed, planner, frame_interval, detailed=detailed))
    return found


def _modelnet(data: Path, objects: int, frame_interval: float) -> list[ScanJob]:
    """Test objects from eight starts each; the first few of each class, evenly picked."""
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
    parser.add_argument("--suite", choices=SUITES, action="append", help="all without it")
    parser.add_argument("--each", type=int, default=6, help="scans a category (furniture)")
    parser.add_argument("--objects", type=int, default=3, help="objects a class (modelnet)")
    parser.add_argument(
        "--frame-interval", type=float, default=2.0, help="between frames [s] (planners, modelnet)"
    )
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the point packs")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument("--tables", action="store_true", help="scan nothing")
    return parser


if __name__ == "__main__":
    sys.exit(main())
