"""Test objects with near duplicates of another class in the training split.

    python -m benchmarks.lookalikes ModelNet10

Each test object is compared with every training object at every yaw of whole azimuth cells; the
largest overlap counts. If a near duplicate has the wrong label that was predicted, the shape alone
does not determine the label. Size, surroundings or use would be needed.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import RESULTS, progress_report, write_page
from circumspect.classification import Classifier
from circumspect.classification.shipped import MODELNET10
from circumspect.datasets import ObjectSet, open_data_set
from circumspect.datasets.validation_split import ALIKE, occupied_and_beside, turned
from circumspect.evaluation.markdown import table

COMMAND = "python -m benchmarks.lookalikes ModelNet10"
PAIRS = 5


def main() -> int:
    """Measure and write `lookalikes.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="ModelNet10")
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    data: Path = given.data
    train, test = open_data_set(data, "train"), open_data_set(data, "test")
    if train.classes != test.classes:
        sys.exit(f"{data}: the classes of its splits differ")
    overlaps = np.stack(list(_overlaps_by_class(train, test)))
    write_page(
        "lookalikes", "Likes of the test objects in the training split", COMMAND,
        *page_text(overlaps, test.labels, _answers(test), test.classes), given.out,
    )  # fmt: skip
    return 0


def page_text(
    overlaps: NDArray[np.floating],
    labels: NDArray[np.integer],
    answers: NDArray[np.integer],
    classes: tuple[str, ...],
) -> tuple[str, dict[str, object]]:
    """The page's text and figures.

    Args:
        overlaps: (n, c) largest overlap of each test object with the training objects of each
            class.
        labels: (n,) true labels.
        answers: (n,) predicted labels.
        classes: Names of the c classes.
    """
    count, wrong, nearest = len(labels), answers != labels, overlaps.argmax(axis=1)
    true = overlaps[np.arange(count), labels] >= ALIKE
    given = overlaps[np.arange(count), answers] >= ALIKE
    rows, figures = [], {}
    for name, some in (("right", ~wrong), ("wrong", wrong)):
        shares = {
            "true class": _share(true[some]),
            "class given": _share(given[some]),
            "nearest is of the true class": _share((nearest == labels)[some]),
        }
        figures[name] = {"objects": int(some.sum()), **shares}
        rows.append([name, str(some.sum()), *(f"{share:.0%}" for share in shares.values())])
    by_nearest = float((nearest == labels).mean())
    mistaken = Counter((classes[labels[i]], classes[answers[i]]) for i in np.flatnonzero(wrong))
    pairs = [[a, b, str(often)] for (a, b), often in mistaken.most_common(PAIRS)]
    text = (
        f"{count} test objects at 0°, classified by `modelnet10`. A like is a training object "
        f"with an overlap of at least {ALIKE:.0%} at some yaw of whole cells: in both objects, "
        "that share of the occupied cells lies on or beside occupied cells of the other.\n\n"
        + table(["answer", "objects", "like in the true class", "like in the class given",
                 "nearest is of the true class"], rows)
        + f"\n\nThe class of the nearest training object is correct for {by_nearest:.1%}.\n\n"
        + table(["is", "is called", "objects"], pairs)
    )  # fmt: skip
    return text, {"nearest_is_right": by_nearest, **figures}


def _share(found: NDArray[np.bool_]) -> float:
    return float(found.mean()) if len(found) else 0.0


def _overlaps_by_class(train: ObjectSet, test: ObjectSet) -> Iterator[NDArray[np.float32]]:
    """(c,) largest overlaps of each test object."""
    pairs = [occupied_and_beside(train, index) for index in range(len(train))]
    cells = np.stack([occupied.ravel() for occupied, _ in pairs])
    beside = np.stack([near.ravel() for _, near in pairs])
    counts, report = cells.sum(axis=1, keepdims=True), progress_report()
    for index in range(len(test)):
        occupied, near = (turned(one) for one in occupied_and_beside(test, index))
        shares = np.minimum(beside @ occupied.T / occupied[0].sum(), cells @ near.T / counts)
        best = shares.max(axis=1)
        yield np.array([best[train.labels == label].max() for label in range(len(train.classes))])
        if index % 50 == 0:
            report(index, len(test), str(test.names[index]))


def _answers(test: ObjectSet) -> NDArray[np.intp]:
    classifier = Classifier.load(MODELNET10, threads=1)
    inputs = (classifier.input_spec.inputs(test.cloud(index)) for index in range(len(test)))
    return np.array([classifier.probabilities(given)[0].argmax() for given in inputs])


if __name__ == "__main__":
    sys.exit(main())
