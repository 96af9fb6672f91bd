"""Answers of classifiers during simulated scans, by coverage.

    python -m benchmarks.scan_answers --gather --snapshots DIR   # scans 140 objects; hours
    python -m benchmarks.scan_answers --snapshots DIR            # runs the classifiers; minutes

Sixty pieces of furniture and eighty test objects of ModelNet10 are scanned once each. The scans are
stored, so that all classifiers get the same scans.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import scans
from benchmarks.report import RESULTS, progress_report, write_page
from benchmarks.scan_job import ScanJob
from benchmarks.scan_snapshots import SHARES, SnapshotJob, gather
from circumspect.classification import Classifier, OnnxClassifier, Prediction
from circumspect.evaluation.markdown import table
from circumspect.gathering.job_pool import LocalPool, records, run_all
from circumspect.geometry import PointCloud
from circumspect.grid import OccupancyGrid

OBJECTS = 8
"""Test objects a class."""
PLACES = (*(f"{share:g}" for share in SHARES), "end")


def main() -> int:
    """Gather the scans and run classifiers on them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gather", action="store_true", help="run missing scans")
    parser.add_argument("--snapshots", type=Path, required=True, help="folder of the scans")
    parser.add_argument(
        "--models", nargs="+", default=["robot", "modelnet10"], help="names or files of classifiers"
    )
    parser.add_argument("--data", type=Path, default=scans.DATA, help="folder of the point packs")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    path = arguments.snapshots / "scans.jsonl"
    if arguments.gather:
        wanted = [SnapshotJob(job, os.fspath(arguments.snapshots)) for job in jobs(arguments.data)]
        run_all(wanted, gather, path, LocalPool(arguments.workers), progress_report())
    found = {
        Path(model).stem: answers(Classifier.load(model), records(path), arguments.snapshots)
        for model in arguments.models
    }
    command = f"python -m benchmarks.scan_answers --snapshots DIR --models {' '.join(found)}"
    write(found, command, arguments.out)
    return 0


def jobs(data: Path) -> list[ScanJob]:
    """The scans: all of the suite `furniture`, and one start of each test object."""
    every = argparse.Namespace(each=6, objects=OBJECTS, frame_interval=2.0, data=data)
    furniture = scans.jobs("furniture", every)
    starts = len(scans.STARTS_DEG)
    # The starts alternate, so that all eight occur.
    return furniture + [
        job
        for number, job in enumerate(scans.jobs("modelnet", every))
        if number % starts == (number // starts) % starts
    ]


def answers(
    classifier: OnnxClassifier, found: list[dict[str, Any]], folder: Path
) -> list[dict[str, Any]]:
    """A row for each scan and place.

    Args:
        classifier: A classifier of grids.
        found: Records of the scans.
        folder: Folder of their snapshots.
    """
    rows = []
    for record in found:
        path = folder / f"{record['key'].replace('/', '_')}.npz"
        if record["true_label"] is None or not path.exists():
            continue
        with np.load(path, allow_pickle=False) as kept:
            for place in PLACES:
                if f"points_{place}" not in kept:
                    continue
                coverage = float(kept[f"coverage_{place}"][0])
                answer = classified_model(
                    classifier,
                    PointCloud(
                        kept[f"points_{place}"].astype(np.float64), areas=kept[f"areas_{place}"]
                    ),
                    kept[f"origins_{place}"], kept[f"ends_{place}"], coverage,
                )  # fmt: skip
                rows.append(
                    {
                        "suite": record["suite"], "object": record["object"], "place": place,
                        "coverage": coverage, "true_label": record["true_label"],
                        "label": answer.label, "probability": answer.probability,
                        "confident": answer.confident, "in_distribution": answer.in_distribution,
                    }
                )  # fmt: skip
    return rows


def classified_model(
    classifier: OnnxClassifier,
    cloud: PointCloud,
    origins_xyz: np.ndarray,
    ends_xyz: np.ndarray,
    coverage: float,
) -> Prediction:
    """Classify a model with its rays, as the pipeline does."""
    input_spec = classifier.input_spec
    views = []
    for grid in input_spec.all_bounds(input_spec.bounds(cloud)):
        found = grid.hits(cloud.points_xyz)
        if len(ends_xyz):
            passed = np.zeros(len(ends_xyz), bool)
            found = found.merged(grid.trace(origins_xyz, ends_xyz, passed))
        views.append(OccupancyGrid(grid, found.states))
    return classifier.classify_grid(*views, metric=True, coverage=coverage)


def write(found: dict[str, list[dict[str, Any]]], command: str, out: Path) -> None:
    """Write the table and the rows of each classifier."""
    lines = [
        [name, suite, *line]
        for name, suite in product(found, ("furniture", "modelnet", "all"))
        for line in _lines([row for row in found[name] if suite in (row["suite"], "all")])
    ]
    head = [
        "classifier", "scans", "coverage", "objects", "accuracy", "confident", "of these wrong",
    ]  # fmt: skip
    text = (
        "Furniture: procedural pieces, a frame every 0.5 s. ModelNet: test objects, a frame "
        "every 2 s. Each coverage: the first frame that reaches it. End: all grids of the complete "
        f"model.\n\n{table(head, lines)}"
    )
    write_page(
        "scan_answers", "Answers during simulated scans", command, text, {"answers": found}, out
    )


def _lines(rows: list[dict[str, Any]]) -> Iterator[list[str]]:
    """A line for each coverage that any of the scans reached."""
    for place in PLACES:
        of = [row for row in rows if row["place"] == place]
        if of:
            correct = [row["label"] == row["true_label"] for row in of]
            confident = [ok for ok, row in zip(correct, of, strict=True) if row["confident"]]
            share = "end" if place == "end" else f"{100 * float(place):.0f} %"
            accuracy = f"{np.mean(correct):.3f}"
            yield [share, str(len(of)), accuracy, str(len(confident)), str(confident.count(False))]


if __name__ == "__main__":
    sys.exit(main())
