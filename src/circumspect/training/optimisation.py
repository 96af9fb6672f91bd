"""How weights are changed and averaged."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor, nn
from torch.optim import Optimizer

from circumspect.training.settings import TrainingSettings

MOMENTUM = 0.9
"""Of stochastic gradient descent."""


def optimizer_for(net: nn.Module, settings: TrainingSettings) -> Optimizer:
    """What changes the weights; the learning rate is set step by step."""
    groups = parameter_groups(net, settings.weight_decay)
    if settings.optimizer == "sgd":
        return torch.optim.SGD(groups, settings.learning_rate, MOMENTUM)
    return torch.optim.AdamW(groups)


def parameter_groups(net: nn.Module, weight_decay: float) -> list[dict[str, Any]]:
    """Parameters for an optimizer; biases and norms are not decayed."""
    matrices = [p for p in net.parameters() if p.ndim > 1]
    vectors = [p for p in net.parameters() if p.ndim <= 1]
    return [
        {"params": matrices, "weight_decay": weight_decay},
        {"params": vectors, "weight_decay": 0.0},
    ]


def forgetful_average(decay: float) -> Callable[[Tensor, Tensor, Tensor | int], Tensor]:
    """Exponential averaging for `AveragedModel` that forgets the first steps faster."""

    def average(averaged: Tensor, current: Tensor, count: Tensor | int) -> Tensor:
        keep = min(decay, (1 + int(count)) / (20 + int(count)))
        return averaged * keep + current * (1 - keep) if averaged.is_floating_point() else current

    return average
