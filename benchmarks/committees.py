"""Ensembles of networks with different inputs, compared with the best network alone.

    python -m benchmarks.committees ModelNet10 runs/planes runs/rivals/mvcnn/training …

Each run classifies the objects that were held back from its training, at yaws that are not whole
azimuth cells. A committee averages the probabilities of its members. The test split is not used,
because the result is for model selection.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import RESULTS, progress_report, write_page
from circumspect.datasets import ObjectSet
from circumspect.evaluation.accuracy import mean_class_accuracy
from circumspect.evaluation.evaluation_set import open_evaluation_set
from circumspect.evaluation.markdown import table
from circumspect.evaluation.predictor import load_predictor
from circumspect.evaluation.yaw_sweep import spread_yaws, sweep_yaw

COMMAND = "python -m benchmarks.committees ModelNet10 RUN …"
YAWS = 8
HEAD = ("members", "epochs", "mean-class accuracy", "accuracy", "worst yaw", "flips")


def main() -> int:
    """Measure and write `committees.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="ModelNet10")
    parser.add_argument(
        "runs", type=Path, nargs="+", help="folders of training runs, the best first"
    )
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    held_back, answers, epochs, report = None, {}, {}, progress_report()
    for done, run in enumerate(given.runs):
        report(done, len(given.runs), str(run))
        settings, found, objects = answered(run, given.data)
        if held_back is not None and objects.names.tolist() != held_back.names.tolist():
            sys.exit(f"{run}: its held-back objects differ from those of {given.runs[0]}")
        if settings["net"] in answers:
            sys.exit(f"{run}: is a second run of {settings['net']}; give one run of each network")
        held_back = objects
        answers[settings["net"]], epochs[settings["net"]] = found, settings["epochs"]
    assert held_back is not None
    rows = [
        {"members": names, **figures([answers[name] for name in names], held_back)}
        for names in committees(list(answers))
    ]
    text = (
        f"{len(held_back)} held-back training objects, whole groups of near duplicates; "
        f"{YAWS} yaws.\n\n" + table(HEAD, [cells(row, epochs) for row in rows])
    )
    write_page(
        "committees", "Networks with unlike inputs, alone and together", COMMAND, text,
        {"objects": len(held_back), "yaws": YAWS, "epochs": epochs, "rows": rows}, given.out,
    )  # fmt: skip
    return 0


def answered(run: Path, data: Path) -> tuple[dict[str, Any], NDArray[np.float64], ObjectSet]:
    """A run's settings, its (yaws, n, c) probabilities, and the n objects held back from it."""
    predictor = load_predictor(run)
    evaluated = open_evaluation_set(predictor, data, "validation")
    if evaluated.seen:
        sys.exit(f"{run}: nothing was held back from its training")
    sweep = sweep_yaw(predictor, evaluated.objects, list(spread_yaws(YAWS)))
    return dict(predictor.training["settings"]), sweep.probabilities, evaluated.objects


def committees(names: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Each network alone, then the first with every combination of the others."""
    yield from ((name,) for name in names)
    for others in range(1, len(names)):
        yield from ((names[0], *chosen) for chosen in combinations(names[1:], others))


def figures(members: Sequence[NDArray[np.float64]], objects: ObjectSet) -> dict[str, float]:
    """Figures of a committee over all yaws."""
    answers = np.mean(members, axis=0).argmax(axis=2)
    correct = answers == objects.labels
    accuracy = correct.mean(axis=1)
    return {
        # An object counts by the share of the yaws at which it is classified correctly.
        "mean_class_accuracy": mean_class_accuracy(
            correct.mean(axis=0), objects.labels, len(objects.classes)
        ),
        "accuracy": float(accuracy.mean()),
        "worst": float(accuracy.min()),
        "flip_rate": float((answers != answers[0]).any(axis=0).mean()),
    }


def cells(row: dict[str, Any], epochs: dict[str, int]) -> list[str]:
    """Cells of a table row."""
    lengths = ", ".join(str(epochs[name]) for name in row["members"])
    shares = [row[key] for key in ("mean_class_accuracy", "accuracy", "worst")]
    words = [f"{share:.3f}" for share in shares]
    return [", ".join(row["members"]), lengths, *words, f"{row['flip_rate']:.1%}"]


if __name__ == "__main__":
    sys.exit(main())
