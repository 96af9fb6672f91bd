"""The objects to evaluate on, and whether the network was fitted to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from circumspect.datasets import ObjectSet, open_data_set, validation_split
from circumspect.datasets.fitted_objects import fitted_objects
from circumspect.evaluation.predictor import TrainedPredictor


@dataclass(frozen=True, eq=False)
class EvaluationSet:
    """A split, and whether the predictor has seen it.

    Attributes:
        objects: The split.
        seen: The network was trained on some of these objects; a figure on them does not hold for
            new ones.
    """

    objects: ObjectSet
    seen: bool


def open_evaluation_set(
    predictor: TrainedPredictor,
    data: Path,
    split: Literal["validation", "test", "train"],
    progress: Callable[[int, int], None] | None = None,
) -> EvaluationSet:
    """Read a split; validation is what the predictor's own training held back.

    If it was not trained on this set, or nothing was held back, validation is drawn in the same
    way.

    Args:
        predictor: Says how it was trained.
        data: Path of the data set, see `open_data_set`.
        split: Which one.
        progress: Called with (done, all) while meshes are sampled.

    Raises:
        InputError: The data set cannot be read.
    """
    objects = open_data_set(data, "test" if split == "test" else "train", progress)
    fitted = fitted_objects(predictor.training, objects)
    if split != "validation":
        return EvaluationSet(objects, seen=bool(fitted.any()))
    held_back = ~fitted
    if not fitted.any() or fitted.all():
        settings = predictor.training.get("settings", {})
        held_back = validation_split(objects, settings.get("validation_salt", ""))
    return EvaluationSet(objects.subset(held_back), seen=bool(fitted[held_back].any()))
