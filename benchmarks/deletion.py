"""Deletion curves: whether the cells with most evidence determine the answer on test objects.

    python -m benchmarks.deletion modelnet10

Occupied cells are emptied by decreasing evidence, in random order, or by increasing evidence. After
each twentieth of the cells, the classifier computes the probability of the label.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.report import RESULTS, machine
from circumspect.classification import (
    Classifier,
    GridSpec,
    OnnxClassifier,
    cell_evidence,
    nearest_examples,
)
from circumspect.classification.shipped import MODELNET10
from circumspect.datasets import open_data_set
from circumspect.evaluation.markdown import table
from circumspect.grid import OccupancyGrid
from circumspect.storage import atomic_open, write_json

STEPS = 20
EACH = 5
"""Objects of each class, evenly over the test split."""
EMPTIED = (0.05, 0.1, 0.2, 0.3, 0.5)
ORDERS = ("most evidence first", "random", "least evidence first")


def main() -> None:
    """Measure and write `deletion.md` and `deletion.json`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="ModelNet10")
    objects = open_data_set(parser.parse_args().data, "test")
    classifier = Classifier.load(MODELNET10, threads=1)
    input_spec = classifier.input_spec
    assert isinstance(input_spec, GridSpec), "modelnet10 takes grids"
    chosen = [
        index
        for label in range(len(objects.classes))
        for index in np.flatnonzero(objects.labels == label)[
            np.linspace(0, (objects.labels == label).sum() - 1, EACH).astype(int)
        ]
    ]
    curves: dict[str, list[np.ndarray]] = {order: [] for order in ORDERS}
    grid_counts: list[int] = []
    correct: list[bool] = []
    agreement: list[float] = []
    for number, index in enumerate(chosen):
        cloud = objects.cloud(int(index))
        grid = input_spec.bounds(cloud).hits(input_spec.surface(cloud).points_xyz)
        found = cell_evidence(classifier, grid)
        grid_counts.append(found.grid_count)
        near = nearest_examples(classifier, cloud)
        truth = objects.classes[objects.labels[index]]
        correct.append(near[0].label == truth)
        named = classifier.classify(cloud).label
        agreement.append(float(np.mean([n.label == named for n in near])))
        values = found.cells[grid.occupied]
        drawn = np.random.default_rng(number).random(len(values))
        for order, key in zip(ORDERS, (-values, drawn, values), strict=True):
            curves[order].append(deletion_curve(classifier, grid, found.label, key))
    report(curves, grid_counts, correct, agreement)


def deletion_curve(
    classifier: OnnxClassifier, grid: OccupancyGrid, label: str, key: np.ndarray
) -> np.ndarray:
    """(STEPS,) probability of the label while cells are emptied by increasing key."""
    cells = np.argwhere(grid.occupied)[np.argsort(key, kind="stable")]
    grids = np.repeat(grid.occupied[None].astype(np.uint8), STEPS, axis=0)
    for step, left in enumerate(grids):
        left[tuple(cells[: step * len(cells) // STEPS].T)] = 0
    column = classifier.classes.index(label)
    return classifier.probabilities(grids[:, None, None])[:, column]


def report(
    curves: dict[str, list[np.ndarray]],
    grid_counts: list[int],
    correct: list[bool],
    agreement: list[float],
) -> None:
    """Write the page and the figures."""
    rows, document = [], {}
    for order, found in curves.items():
        mean = np.mean(found, axis=0)
        shares = [f"{100 * mean[round(share * STEPS)]:.0f} %" for share in EMPTIED]
        rows.append([order, *shares, f"{mean.mean():.2f}"])
        document[order] = mean.tolist()
    head = ["emptied", *(f"{100 * share:.0f} %" for share in EMPTIED), "mean of the curve"]
    facts = machine()
    lines = [
        "# Evidence: deletion curves",
        "",
        "`python -m benchmarks.deletion modelnet10`",
        "",
        f"Mean probability of the label of {len(grid_counts)} test objects of ModelNet10 ({EACH} a "
        "class) when these shares of their occupied cells are emptied:",
        "",
        table(head, rows),
        "",
        f"- grids classified for the evidence of an object: {np.mean(grid_counts):.0f} (mean)",
        f"- nearest training object of the true class: {np.mean(correct):.0%} of the objects",
        f"- share of the five nearest that have the predicted class: {np.mean(agreement):.0%}",
        "",
        *(f"- {key}: {value}" for key, value in facts.items()),
    ]
    with atomic_open(RESULTS / "deletion.md") as stream:
        stream.write("\n".join(lines) + "\n")
    write_json(
        RESULTS / "deletion.json",
        {
            "machine": facts, "objects": len(grid_counts), "steps": STEPS, "curves": document,
            "grids_asked": float(np.mean(grid_counts)),
            "nearest_is_right": float(np.mean(correct)),
            "five_nearest_agree": float(np.mean(agreement)),
        },
    )  # fmt: skip


if __name__ == "__main__":
    main()
