"""Optimizers and averaging of weights."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor, nn
from torch.optim import Optimizer

from circumspect.training.settings import TrainingSettings

MOMENTUM = 0.9
"""Momentum of stochastic gradient descent."""


def optimizer_for(net: nn.Module, settings: TrainingSettings) -> Optimizer:
    """Create the optimizer; the learning rate is set at each step."""
    groups = parameter_groups(net, settings.weight_decay)
    if settings.optimizer == "sgd":
        return torch.optim.SGD(groups, settings.learning_rate, MOMENTUM)
    return torch.optim.AdamW(groups)


def parameter_groups(net: nn.Module, weight_decay: float) -> list[dict[str, Any]]:
    """Parameter groups for an optimizer, without weight decay for biases and norms."""
    matrices = [p for p in net.parameters() if p.ndim > 1]
    vectors = [p for p in net.parameters() if p.ndim <= 1]
    return [
        {"params": matrices, "weight_decay": weight_decay},
        {"params": vectors, "weight_decay": 0.0},
    ]


def exponential_average(decay: float) -> Callable[[Tensor, Tensor, Tensor | int], Tensor]:
    """Exponential averaging for `AveragedModel`, with faster decay in the first steps."""

    def average(averaged: Tensor, current: Tensor, count: Tensor | int) -> Tensor:
        keep = min(decay, (1 + int(count)) / (20 + int(count)))
        return averaged * keep + current * (1 - keep) if averaged.is_floating_point() else current

    return average
