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


def cost_of(net: nn.Module, input_shape: tuple[int, ...], context: int | None = None) -> Cost:
    """Count parameters and multiply-adds.

    Args:
        net: Takes (1, *input_shape), and (1, context) where that is given.
        input_shape: Of one input, as channels where the network is shown states of cells.
        context: Width of what it is shown beside.
    """
    training = net.training
    net.eval()
    with torch.no_grad(), FlopCounterMode(display=False) as counter:
        beside = () if context is None else (torch.zeros(1, context),)
        net(torch.zeros(1, *input_shape), *beside)
    net.train(training)
    parameters = sum(parameter.numel() for parameter in net.parameters())
    return Cost(parameters, counter.get_total_flops() // 2)
