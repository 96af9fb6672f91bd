"""How well the averaged weights do on the objects held back."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from circumspect.classification import InputRecipe
from circumspect.datasets import ObjectSet
from circumspect.evaluation.accuracy import mean_class_accuracy
from circumspect.evaluation.yaw_sweep import inputs_of

YAWS: list[float] = np.deg2rad([0.0, 3.0, 7.0]).tolist()
"""[rad], on and off the cells; hardly a turn, so that networks that mind one are chosen fairly."""
YAWS_AROUND: list[float] = np.deg2rad([0.0, 123.0, 247.0]).tolist()
"""[rad], as many over the whole turn, for networks that are trained at random yaw."""


def examined_yaws(random_yaw: bool) -> list[float]:
    """The yaws [rad] at which held-back objects are shown.

    Args:
        random_yaw: The network is trained at random yaw.
    """
    return YAWS_AROUND if random_yaw else YAWS


class Examiner(Protocol):
    """Measures a network on what was held back."""

    def examine(self, net: nn.Module) -> dict[str, float]:
        """Mean-class accuracy, instance accuracy and loss."""
        ...


class ObjectExaminer:
    """Measures a network on complete objects, see `Examiner`.

    Args:
        objects: Held back, at least one.
        recipe: What the network is shown.
        device: Where the network runs.
        random_yaw: The network is trained at random yaw.

    Raises:
        InputError: An object spans no shape.
    """

    def __init__(
        self,
        objects: ObjectSet,
        recipe: InputRecipe,
        device: torch.device,
        random_yaw: bool = False,
    ) -> None:
        self._labels, self._classes = objects.labels, len(objects.classes)
        self._device = device
        yaws = examined_yaws(random_yaw)
        inputs = [inputs_of(recipe, objects, i, yaws) for i in range(len(objects))]
        self._inputs = np.stack(inputs, axis=1)

    def examine(self, net: nn.Module) -> dict[str, float]:
        """Mean-class accuracy, instance accuracy and loss, each the mean over the yaws."""
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
