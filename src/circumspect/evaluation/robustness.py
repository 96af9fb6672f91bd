"""Accuracy after things went wrong with the clouds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets import ObjectSet
from circumspect.datasets.corruption import CORRUPTIONS, SEVERITIES, corrupted
from circumspect.errors import GeometryError, InputError
from circumspect.evaluation.predictor import Predictor, check_classes

BATCH = 16


@dataclass(frozen=True, eq=False)
class Robustness:
    """Accuracy by corruption and severity.

    Attributes:
        clean: Without any.
        accuracy: Corruption to (5,) accuracies at severities 1 … 5.
    """

    clean: float
    accuracy: dict[str, NDArray[np.float64]]

    @property
    def mean(self) -> float:
        """Over all corruptions and severities."""
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
) -> Robustness:
    """Corrupt all objects in all ways, at 0° of yaw, and name them.

    An object of which nothing is left that spans a shape counts as named wrongly.

    Args:
        predictor: What names them.
        objects: The set.
        seed: Of all chance; all predictors meet the same clouds.
        progress: Called with (done, all) passes over the set.

    Raises:
        InputError: The set is empty.
        WeightsError: The weights know other classes than the set.
    """
    check_classes(predictor, objects)
    if not len(objects):
        raise InputError("no objects: nothing to evaluate")
    passes = [(kind, severity) for kind in CORRUPTIONS for severity in SEVERITIES]
    clean = _accuracy(predictor, objects, None, seed)
    accuracy = {kind: np.zeros(len(SEVERITIES)) for kind in CORRUPTIONS}
    for done, (kind, severity) in enumerate(passes):
        accuracy[kind][severity - 1] = _accuracy(predictor, objects, (kind, severity), seed)
        if progress:
            progress(done + 1, len(passes))
    return Robustness(clean, accuracy)


def _accuracy(
    predictor: Predictor, objects: ObjectSet, how: tuple[str, int] | None, seed: int
) -> float:
    right = 0
    for first in range(0, len(objects), BATCH):
        indices = range(first, min(first + BATCH, len(objects)))
        made = [(i, _input(predictor, objects, i, how, seed)) for i in indices]
        known = [(i, given) for i, given in made if given is not None]
        if known:
            answers = predictor.probabilities(np.concatenate([given for _, given in known]))
            right += int((answers.argmax(axis=1) == objects.labels[[i for i, _ in known]]).sum())
    return right / len(objects)


def _input(
    predictor: Predictor, objects: ObjectSet, index: int, how: tuple[str, int] | None, seed: int
) -> NDArray[Any] | None:
    cloud = objects.cloud(index)
    try:
        if how is not None:
            kind, severity = how
            chance = [seed, index, list(CORRUPTIONS).index(kind), severity]
            cloud = corrupted(cloud, kind, severity, np.random.default_rng(chance))
        return predictor.recipe.inputs(cloud)
    except GeometryError:
        return None
