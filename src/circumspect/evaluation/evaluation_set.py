"""The objects to evaluate on, and whether the network saw them in training."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from circumspect.datasets import ObjectSet, open_data_set, validation_split
from circumspect.evaluation.predictor import Predictor


@dataclass(frozen=True, eq=False)
class EvaluationSet:
    """A split, as seen by one predictor.

    Attributes:
        objects: The split.
        seen: The network was trained on these objects: a figure on them says nothing about new
            ones.
    """

    objects: ObjectSet
    seen: bool


def open_evaluation_set(
    predictor: Predictor,
    data: Path,
    split: Literal["validation", "test", "train"],
    progress: Callable[[int, int], None] | None = None,
) -> EvaluationSet:
    """Read a split; validation is what the predictor's own training held back.

    Args:
        predictor: Says how it was trained.
        data: Path of the data set, see `open_data_set`.
        split: Which one.
        progress: Called with (done, all) while meshes are sampled.

    Raises:
        InputError: The data set can not be read.
    """
    objects = open_data_set(data, "test" if split == "test" else "train", progress)
    settings = predictor.training.get("settings", {})
    trained_on_these = predictor.training.get("data") == objects.digest
    if split != "validation":
        return EvaluationSet(objects, seen=trained_on_these)
    held_back = validation_split(objects, settings.get("validation_salt", ""))
    seen = trained_on_these and not settings.get("validation", True)
    return EvaluationSet(objects.subset(held_back), seen=seen)
