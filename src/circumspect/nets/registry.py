"""Every network by name."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import dataclass, field

from torch import nn

from circumspect.classification import GridRecipe
from circumspect.errors import InputError
from circumspect.nets.committee import Committee
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


def _pair(classes: int, shape: tuple[int, int, int]) -> Committee:
    return Committee(Planes(classes, shape, widths=(24, 48, 96), circle=192) for _ in range(2))


NETS = {
    spec.name: spec
    for spec in (
        NetSpec(
            "planes",
            "ours: wrapped 2D convolutions on two stacks of planes, circular mixing, RWMP and mean",
            Planes,
        ),
        NetSpec("planes-pair", "ours: two narrower `planes`, averaged", _pair),
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
    """Build a network with fresh weights.

    Args:
        name: One of `NETS`.
        classes: How many.
        shape: Of its input grid.

    Raises:
        InputError: No network of that name.
    """
    return net_spec(name).build(classes, shape)
