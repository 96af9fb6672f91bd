"""Inputs of networks, and networks that are away from their trivial start."""

import torch

from circumspect.classification import GridSpec, PointsSpec
from circumspect.nets import NETS, build_net


def small_input_spec(name):
    """The input specification of a network; a smaller grid for moon2018, whose weights grow with it."""
    if name.startswith("moon2018"):
        return GridSpec(shape=(14, 14, 14))
    return NETS[name].input_spec


def some_inputs(input_spec, count, seed=0):
    """(count, *input_shape): grids that are a tenth full, or points within the cylinder."""
    chance = torch.Generator().manual_seed(seed)
    drawn = torch.rand(count, *input_spec.input_shape, generator=chance)
    if isinstance(input_spec, PointsSpec):
        return (drawn - 0.5) * 1.3
    return (drawn < 0.1).float()


def trained_looking(name, input_spec=None, classes=3, seed=0):
    """A network whose batch norms and last layers are away from their trivial start."""
    torch.manual_seed(seed)
    input_spec = input_spec or small_input_spec(name)
    net = build_net(name, classes, input_spec)
    with torch.no_grad():
        for parameter in net.parameters():
            parameter.add_(0.05 * torch.randn_like(parameter))
        net.train()
        net(some_inputs(input_spec, 8, seed))
    return net.eval()
