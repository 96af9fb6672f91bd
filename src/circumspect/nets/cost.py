"""Number of parameters and operations of a network."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import nn
from torch.utils.flop_counter import FlopCounterMode


@dataclass(frozen=True)
class Cost:
    """Size and computational cost of a network.

    Attributes:
        parameters: Number of trained parameters.
        multiply_adds: Multiply-adds per input, in convolutions and matrix products.
    """

    parameters: int
    multiply_adds: int


def cost_of(net: nn.Module, input_shape: tuple[int, ...], context: int | None = None) -> Cost:
    """Count parameters and multiply-adds.

    Args:
        net: Network with the input (1, *input_shape), and (1, context) if given.
        input_shape: Shape of one input, with channels for cell states.
        context: Width of the context input; None without one.
    """
    training = net.training
    net.eval()
    with torch.no_grad(), FlopCounterMode(display=False) as counter:
        beside = () if context is None else (torch.zeros(1, context),)
        net(torch.zeros(1, *input_shape), *beside)
    net.train(training)
    parameters = sum(parameter.numel() for parameter in net.parameters())
    return Cost(parameters, counter.get_total_flops() // 2)
