"""Accuracy on corrupted clouds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets import ObjectSet
from circumspect.datasets.corruption import CORRUPTIONS, SEVERITIES, corrupted
from circumspect.errors import GeometryError, InputError
from circumspect.evaluation.predictor import Predictor, check_classes
from circumspect.evaluation.yaw_sweep import inputs_of

BATCH = 16
CLEAN = "none"
"""Name of the uncorrupted pass."""
PASSES = {CLEAN: (0,), **dict.fromkeys(CORRUPTIONS, SEVERITIES)}
"""Severities of every corruption; each is one pass over the set."""
Keep = Callable[[str, Callable[[], list[float]]], list[float]]
"""Takes a corruption's name and its measurement; returns the accuracy of each severity."""


def _at_once(kind: str, measure: Callable[[], list[float]]) -> list[float]:  # noqa: ARG001
    return measure()


@dataclass(frozen=True, eq=False)
class Robustness:
    """Accuracy by corruption and severity.

    Attributes:
        clean: Without corruption.
        accuracy: Corruption to (5,) accuracies at severities 1 … 5.
    """

    clean: float
    accuracy: dict[str, NDArray[np.float64]]

    @property
    def mean(self) -> float:
        """Mean over all corruptions and severities."""
        return float(np.mean([row.mean() for row in self.accuracy.values()]))

    def to_dict(self) -> dict[str, Any]:
        """JSON types."""
        return {
            "clean": self.clean,
            "mean": self.mean,
            "accuracy": {kind: row.tolist() for kind, row in self.accuracy.items()},
        }


def measure_robustness(
    predictor: Predictor,
    objects: ObjectSet,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
    keep: Keep = _at_once,
) -> Robustness:
    """Corrupt all objects in all ways, at 0° of yaw, and classify them.

    An object without a shape after corruption counts as classified wrongly.

    Args:
        predictor: The classifier.
        objects: The set.
        seed: Of the corruptions; all predictors get the same clouds.
        progress: Called with (done, all) passes over the set.
        keep: Called for `CLEAN` and for each corruption; may return an earlier measurement.

    Raises:
        InputError: The set is empty, or an uncorrupted object spans no shape.
        WeightsError: The weights know other classes than the set.
    """
    check_classes(predictor, objects)
    if not len(objects):
        raise InputError("no objects: nothing to evaluate")
    found: dict[str, list[float]] = {}
    for kind, severities in PASSES.items():
        report = partial(_report, progress, sum(map(len, found.values())))
        found[kind] = keep(kind, partial(_row, predictor, objects, kind, seed, report))
        report(len(severities))
    (clean,) = found.pop(CLEAN)
    return Robustness(clean, {kind: np.array(row) for kind, row in found.items()})


def _report(progress: Callable[[int, int], None] | None, before: int, done: int) -> None:
    if progress:
        progress(before + done, sum(map(len, PASSES.values())))


def _row(
    predictor: Predictor, objects: ObjectSet, kind: str, seed: int, report: Callable[[int], None]
) -> list[float]:
    row = []
    for severity in PASSES[kind]:
        row.append(_accuracy(predictor, objects, kind, severity, seed))
        report(len(row))
    return row


def _accuracy(
    predictor: Predictor, objects: ObjectSet, kind: str, severity: int, seed: int
) -> float:
    right = 0
    for first in range(0, len(objects), BATCH):
        indices = range(first, min(first + BATCH, len(objects)))
        made = [(i, _input(predictor, objects, i, kind, severity, seed)) for i in indices]
        known = [(i, given) for i, given in made if given is not None]
        if known:
            answers = predictor.probabilities(np.concatenate([given for _, given in known]))
            right += int((answers.argmax(axis=1) == objects.labels[[i for i, _ in known]]).sum())
    return right / len(objects)


def _input(
    predictor: Predictor, objects: ObjectSet, index: int, kind: str, severity: int, seed: int
) -> NDArray[Any] | None:
    if kind == CLEAN:
        return inputs_of(predictor.input_spec, objects, index, [0.0])
    chance = [seed, index, list(CORRUPTIONS).index(kind), severity]
    try:
        cloud = corrupted(objects.cloud(index), kind, severity, np.random.default_rng(chance))
        return predictor.input_spec.inputs(cloud)
    except GeometryError:
        return None
