"""Accuracy by number of points: `python -m benchmarks.few_points ModelNet10`.

`modelnet10` classifies the test objects from fewer and fewer of their points. The table also gives
the share of objects that it considers in distribution.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.report import RESULTS, progress_report, write_page
from circumspect.classification import OnnxClassifier, Prediction
from circumspect.classification.cloud_checks import MIN_POINTS
from circumspect.classification.shipped import MODELNET10
from circumspect.datasets import ObjectSet, open_data_set
from circumspect.evaluation.markdown import table
from circumspect.geometry import PointCloud

COMMAND = "python -m benchmarks.few_points ModelNet10"
COUNTS = (16, 32, 64, 96, MIN_POINTS, 192, 256, 512, 1024)


def main() -> int:
    """Measure and write `few_points.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="ModelNet10")
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    test = open_data_set(given.data, "test")
    classifier, report = OnnxClassifier.load(MODELNET10, threads=1), progress_report()
    if classifier.classes != test.classes:
        sys.exit(f"{given.data}: its classes differ from those of {MODELNET10}")
    rows = []
    for index, count in enumerate(COUNTS):
        answers = [classifier.classify(_thinned(test, i, count)) for i in range(len(test))]
        rows.append(measured(count, answers, test, classifier.description["unknown_beyond"]))
        report(index, len(COUNTS), f"{count} points")
    write_page(
        "few_points", "Objects of a few points", COMMAND,
        page_text(rows, len(test)), {"counts": rows}, given.out,
    )  # fmt: skip
    return 0


def measured(
    count: int, answers: Sequence[Prediction], test: ObjectSet, max_distance: float
) -> dict[str, float]:
    """A row of the table.

    Args:
        count: Number of points of each object.
        answers: Answers to the objects of the set.
        test: The set.
        max_distance: Distance to the nearest training object up to which an object is in
            distribution.
    """
    correct = np.array([test.classes.index(a.label) for a in answers]) == test.labels
    near = np.array([a.distance is not None and a.distance <= max_distance for a in answers])
    return {
        "points": count,
        "accuracy": float(correct.mean()),
        "near": float(near.mean()),
        "incorrect_of_near": float((~correct)[near].mean()) if near.any() else 0.0,
        "in_distribution": float(np.mean([a.in_distribution for a in answers])),
    }


def page_text(rows: Sequence[dict[str, float]], objects: int) -> str:
    """The page's text."""
    lines = [
        [str(row["points"]), *(f"{row[name]:.1%}" for name in ("accuracy", "near")),
         f"{row['incorrect_of_near']:.1%}", f"{row['in_distribution']:.1%}"]
        for row in rows
    ]  # fmt: skip
    return (
        f"{objects} test objects at 0°, random points of each. Near: within the distance of the "
        f"open-set test from a training object. From {MIN_POINTS} points on, near objects are in "
        "distribution unless the cloud seems to contain the floor; with fewer points none is.\n\n"
        + table(["points", "correct", "near", "incorrect of these", "in distribution"], lines)
    )


def _thinned(test: ObjectSet, index: int, count: int) -> PointCloud:
    points = test.cloud(index).points_xyz
    drawn = np.random.default_rng(index).permutation(len(points))[:count]
    return PointCloud(points[drawn])


if __name__ == "__main__":
    sys.exit(main())
