"""What a run trains on, and what it is measured on: one form for all kinds of inputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch

from circumspect.classification import InputRecipe
from circumspect.datasets import GridCache, ObjectSet
from circumspect.training.batches import Batches, DrawnBatches
from circumspect.training.examiner import Examiner, ObjectExaminer
from circumspect.training.held_back import fitted_and_held_back
from circumspect.training.samples import TrainingSamples
from circumspect.training.settings import TrainingSettings

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class TrainingData:
    """All that a run is shown.

    Attributes:
        classes: Of the network's outputs.
        digest: A hash of all objects.
        count: How many objects train.
        fitted: Their names; none where they are too many to be listed.
        held_back: How many objects do not train.
        batches: Of those that train.
        examiner: Measures a network on those held back; None where there are none.
        class_weights: Weights of the classes in the loss; None where all are 1.
    """

    classes: tuple[str, ...]
    digest: str
    count: int
    fitted: list[str]
    held_back: int
    batches: Batches
    examiner: Examiner | None
    class_weights: tuple[float, ...] | None = None


def object_data(
    objects: ObjectSet,
    settings: TrainingSettings,
    recipe: InputRecipe,
    cache: GridCache,
    device: torch.device,
    progress: Progress,
) -> TrainingData:
    """Complete objects of a labelled set, changed by `Augmentation`.

    Raises:
        InputError: A class has no object that trains, or the set does not fit the settings.
        OutputError: The cache can not be written.
    """
    fit, held_back = fitted_and_held_back(objects, settings)
    return TrainingData(
        objects.classes, objects.digest, len(fit), fit.names.tolist(), len(held_back),
        DrawnBatches(TrainingSamples(fit, settings, recipe, cache, progress), settings),
        ObjectExaminer(held_back, recipe, device, settings.random_yaw) if len(held_back) else None,
    )  # fmt: skip
