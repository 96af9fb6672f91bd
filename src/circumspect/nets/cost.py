"""What a network costs."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import nn
from torch.utils.flop_counter import FlopCounterMode


@dataclass(frozen=True)
class Cost:
    """Size and work of a network.

    Attributes:
        parameters: Trained numbers.
        multiply_adds: For one input, of convolutions and matrix products.
    """

    parameters: int
    multiply_adds: int


def cost_of(net: nn.Module, input_shape: tuple[int, ...]) -> Cost:
    """Count parameters and multiply-adds.

    Args:
        net: Takes (1, *input_shape).
        input_shape: Of one input.
    """
    training = net.training
    net.eval()
    with torch.no_grad(), FlopCounterMode(display=False) as counter:
        net(torch.zeros(1, *input_shape))
    net.train(training)
    parameters = sum(parameter.numel() for parameter in net.parameters())
    return Cost(parameters, counter.get_total_flops() // 2)
