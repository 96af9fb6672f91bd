"""Do the cells of most evidence carry the answer? Deletion curves on test objects.

    python -m benchmarks.deletion modelnet10

Cells are emptied, those of most evidence first, or in random order, or those of most evidence
against first; after each twentieth the classifier is asked how probable the label still is.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.report import machine, write_report
from circumspect.classification import Classifier, cell_evidence, nearest_examples
from circumspect.datasets import open_data_set
from circumspect.evaluation.markdown import table
from circumspect.grid import OccupancyGrid

STEPS = 20
EACH = 6
"""Objects of each class, evenly over the test split."""
SHOWN = (0.05, 0.1, 0.2, 0.3, 0.5)
ORDERS = ("most evidence first", "random", "least evidence first")


def main(data: Path) -> None:
    objects = open_data_set(data, "test")
    classifier = Classifier.load(threads=1)
    chosen = [
        index
        for label in range(len(objects.classes))
        for index in np.flatnonzero(objects.labels == label)[
            np.linspace(0, (objects.labels == label).sum() - 1, EACH).astype(int)
        ]
    ]
    curves: dict[str, list[np.ndarray]] = {order: [] for order in ORDERS}
    seconds, asked, alike, agreeing = [], [], [], []
    for number, index in enumerate(chosen):
        cloud = objects.cloud(int(index))
        grid = classifier.recipe.bounds(cloud).hits(classifier.recipe.surface(cloud).points_xyz)
        start = time.perf_counter()
        found = cell_evidence(classifier, grid)
        seconds.append(time.perf_counter() - start)
        asked.append(found.asked)
        near = nearest_examples(classifier, cloud)
        truth = objects.classes[objects.labels[index]]
        alike.append(near[0].label == truth)
        agreeing.append(np.mean([n.label == classifier.classify(cloud).label for n in near]))
        values = found.cells[grid.occupied]
        drawn = np.random.default_rng(number).random(len(values))
        for order, key in zip(ORDERS, (-values, drawn, values), strict=True):
            curves[order].append(deletion_curve(classifier, grid, found.label, key))
    report(curves, seconds, asked, alike, agreeing)


def deletion_curve(
    classifier, grid: OccupancyGrid, label: str, key: np.ndarray
) -> np.ndarray:
    """(STEPS,) probability of the label as ever more cells are emptied, smallest key first."""
    cells = np.argwhere(grid.occupied)[np.argsort(key, kind="stable")]
    grids = np.repeat(grid.occupied[None].astype(np.uint8), STEPS, axis=0)
    for step, left in enumerate(grids):
        left[tuple(cells[: step * len(cells) // STEPS].T)] = 0
    column = classifier.classes.index(label)
    return classifier.probabilities(grids[:, None, None])[:, column]


def report(curves, seconds, asked, alike, agreeing) -> None:
    rows = []
    for order, found in curves.items():
        mean = np.mean(found, axis=0)
        shares = [f"{100 * mean[round(share * STEPS)]:.0f} %" for share in SHOWN]
        rows.append([order, *shares, f"{mean.mean():.2f}"])
    head = ["cells emptied", *(f"{100 * share:.0f} %" for share in SHOWN), "area under the curve"]
    count = len(seconds)
    lines = [
        "# What evidence is worth",
        "",
        f"Mean probability of the label of {count} test objects of ModelNet10 ({EACH} a class), "
        "when so many of their occupied cells are emptied. One grid an object.",
        "",
        table(head, rows),
        "",
        f"Evidence of an object: {np.mean(asked):.0f} changed grids, {np.median(seconds):.1f} s on "
        f"one thread (median, {machine()}).",
        "",
        f"The nearest training object is of the true class for {100 * np.mean(alike):.0f} % of "
        f"them; of the five nearest {100 * np.mean(agreeing):.0f} % are of the class that is named.",
        "",
        "`python -m benchmarks.deletion modelnet10`",
    ]
    write_report("deletion.md", "\n".join(lines))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
