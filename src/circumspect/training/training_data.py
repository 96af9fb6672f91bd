"""What a run trains on, and what it is measured on: one form for all kinds of inputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray

from circumspect.classification import InputRecipe
from circumspect.datasets import GridCache, ObjectSet
from circumspect.training.examiner import Examiner, ObjectExaminer
from circumspect.training.held_back import fitted_and_held_back
from circumspect.training.samples import TrainingSamples
from circumspect.training.settings import TrainingSettings

Progress = Callable[[int, int], None]


class Samples(Protocol):
    """Inputs of training objects under one index."""

    epoch: int
    """Draws an epoch."""
    chances: NDArray[np.float64]
    """(n,) chance of each object; they sum to 1."""
    targets: NDArray[np.float32]
    """(n, c) one-hot targets."""

    def inputs(
        self, chosen: NDArray[np.int64], replicas: NDArray[np.int64], rng: np.random.Generator
    ) -> tuple[NDArray[Any], ...]:
        """What the network is shown of chosen objects.

        Args:
            chosen: (b,) indices.
            replicas: (b,) the variant of each.
            rng: Of what is drawn for each batch anew.

        Returns:
            Arrays of b rows: the inputs, and their contexts where the network takes them.
        """
        ...


@dataclass(frozen=True)
class TrainingData:
    """All that a run is shown.

    Attributes:
        classes: Of the network's outputs.
        digest: A hash of all objects.
        fitted: Names of the objects that train.
        held_back: How many objects do not.
        samples: Inputs of those that train.
        examiner: Measures a network on those held back; None where there are none.
    """

    classes: tuple[str, ...]
    digest: str
    fitted: list[str]
    held_back: int
    samples: Samples
    examiner: Examiner | None


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
        objects.classes, objects.digest, fit.names.tolist(), len(held_back),
        TrainingSamples(fit, settings, recipe, cache, progress),
        ObjectExaminer(held_back, recipe, device, settings.random_yaw) if len(held_back) else None,
    )  # fmt: skip
