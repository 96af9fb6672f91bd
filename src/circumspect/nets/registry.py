"""Every network by name."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import dataclass, field

import torch
from torch import nn

from circumspect.classification import GridRecipe
from circumspect.errors import InputError
from circumspect.nets.headed_planes import HeadedPlanes
from circumspect.nets.planes import Planes


@dataclass(frozen=True)
class NetSpec:
    """A network that can be built.

    Attributes:
        name: Its name on the command line.
        summary: What it is, in one line.
        build: Makes it from the number of classes and the grid's shape.
        recipe: The grids it is meant for.
    """

    name: str
    summary: str
    build: Callable[[int, tuple[int, int, int]], nn.Module]
    recipe: GridRecipe = field(default_factory=GridRecipe)


NETS = {
    spec.name: spec
    for spec in (
        NetSpec(
            "planes",
            "ours: wrapped 2D convolutions on two stacks of planes, circular mixing, RWMP and mean",
            Planes,
        ),
        NetSpec(
            "headed-planes",
            "ours: `planes`, narrower, that also learns which way the object faces",
            HeadedPlanes,
        ),
    )
}


def net_spec(name: str) -> NetSpec:
    """Look a network up.

    Raises:
        InputError: No network of that name.
    """
    if name in NETS:
        return NETS[name]
    near = difflib.get_close_matches(name, NETS, 1)
    hint = f"; did you mean {near[0]}?" if near else ""
    raise InputError(f"no network '{name}'; known: {', '.join(NETS)}{hint}")


def build_net(name: str, classes: int, shape: tuple[int, int, int]) -> nn.Module:
    """Build a network with fresh weights, laid out as CPU convolutions like them best.

    Args:
        name: One of `NETS`.
        classes: How many.
        shape: Of its input grid.

    Raises:
        InputError: No network of that name.
    """
    net = net_spec(name).build(classes, shape)
    layouts = {4: torch.channels_last, 5: torch.channels_last_3d}
    for parameter in net.parameters():
        if layout := layouts.get(parameter.ndim):
            parameter.data = parameter.data.contiguous(memory_format=layout)
    return net
