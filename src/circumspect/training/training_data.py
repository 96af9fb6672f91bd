"""Training data of a run, and the evaluation on held-back objects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from circumspect.classification import InputSpec
from circumspect.datasets import GridCache, ObjectSet
from circumspect.datasets.validation_split import validation_split
from circumspect.errors import InputError
from circumspect.evaluation.accuracy import mean_class_accuracy
from circumspect.evaluation.yaw_sweep import inputs_of
from circumspect.training.batches import Batches, DrawnBatches
from circumspect.training.samples import TrainingSamples
from circumspect.training.settings import TrainingSettings

Progress = Callable[[int, int], None]
YAWS: list[float] = np.deg2rad([0.0, 3.0, 7.0]).tolist()
"""Yaws [rad] on and off the cells; small, so that networks without invariance compare fairly."""
YAWS_AROUND: list[float] = np.deg2rad([0.0, 123.0, 247.0]).tolist()
"""Yaws [rad] over a full turn, for networks that are trained at random yaw."""


def examined_yaws(random_yaw: bool) -> list[float]:
    """The yaws of the held-back objects [rad].

    Args:
        random_yaw: Whether the network is trained at random yaw.
    """
    return YAWS_AROUND if random_yaw else YAWS


class Examiner(Protocol):
    """Measures a network on held-back objects."""

    def examine(self, net: nn.Module) -> dict[str, float]:
        """Mean-class accuracy, instance accuracy and loss."""
        ...


class ObjectExaminer:
    """Measures a network on complete objects, see `Examiner`.

    Args:
        objects: Held-back objects, at least one.
        input_spec: The network's inputs.
        device: Device of the network.
        random_yaw: Whether the network is trained at random yaw.

    Raises:
        InputError: An object spans no shape.
    """

    def __init__(
        self,
        objects: ObjectSet,
        input_spec: InputSpec,
        device: torch.device,
        random_yaw: bool = False,
    ) -> None:
        self._labels, self._classes = objects.labels, len(objects.classes)
        self._device = device
        yaws = examined_yaws(random_yaw)
        inputs = [inputs_of(input_spec, objects, i, yaws) for i in range(len(objects))]
        self._inputs = np.stack(inputs, axis=1)

    def examine(self, net: nn.Module) -> dict[str, float]:
        """Mean-class accuracy, instance accuracy and loss, averaged over the yaws."""
        net.eval()
        labels = torch.from_numpy(self._labels)
        logits = [self._logits(net, inputs) for inputs in self._inputs]
        share = np.mean([(row.argmax(1) == labels).numpy() for row in logits], axis=0)
        losses = [float(functional.cross_entropy(row, labels)) for row in logits]
        return {
            "validation_accuracy": mean_class_accuracy(share, self._labels, self._classes),
            "validation_instance_accuracy": float(share.mean()),
            "validation_loss": float(np.mean(losses)),
        }

    @torch.no_grad()
    def _logits(self, net: nn.Module, inputs: NDArray[Any]) -> Tensor:
        count, views = inputs.shape[:2]
        flat = torch.from_numpy(inputs.reshape(count * views, *inputs.shape[2:]))
        parts = [net(part.to(self._device).float()).float().cpu() for part in flat.split(64)]
        return torch.cat(parts).view(count, views, -1).mean(1)


@dataclass(frozen=True)
class TrainingData:
    """The data of a run.

    Attributes:
        classes: Classes of the network's outputs.
        digest: Hash of all objects.
        count: Number of training objects.
        fitted: Names of the training objects; empty if there are too many.
        held_back: Number of held-back objects.
        batches: Batches of the training objects.
        examiner: Measures a network on the held-back objects; None without any.
        class_weights: Weights of the classes in the loss; None if all are 1.
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
    input_spec: InputSpec,
    cache: GridCache,
    device: torch.device,
    progress: Progress,
) -> TrainingData:
    """Training data from complete objects of a labelled set, changed by `Augmentation`.

    Raises:
        InputError: A class has no training object, or the set does not match the settings.
        OutputError: The cache cannot be written.
    """
    fit, held_back = fitted_and_held_back(objects, settings)
    return TrainingData(
        objects.classes, objects.digest, len(fit), fit.names.tolist(), len(held_back),
        DrawnBatches(TrainingSamples(fit, settings, input_spec, cache, progress), settings),
        ObjectExaminer(held_back, input_spec, device, settings.random_yaw)
        if len(held_back)
        else None,
    )  # fmt: skip


def fitted_and_held_back(
    objects: ObjectSet, settings: TrainingSettings
) -> tuple[ObjectSet, ObjectSet]:
    """Split the training objects.

    Args:
        objects: The official training split.
        settings: Settings of validation.

    Returns:
        The training objects and the held-back ones; the latter may be empty.

    Raises:
        InputError: A class has no training object, or no object is held back although requested.
    """
    held_back = np.zeros(len(objects), bool)
    if settings.validation:
        held_back = validation_split(objects, settings.validation_salt)
    fit = objects.subset(~held_back)
    if missing := set(range(len(objects.classes))) - set(fit.labels.tolist()):
        names = ", ".join(objects.classes[i] for i in sorted(missing))
        raise InputError(f"no training object of class {names}; complete the data set")
    if settings.validation and not held_back.any():
        raise InputError(
            "no object falls into the validation split; add objects, or train with --no-validation"
        )
    return fit, objects.subset(held_back)
