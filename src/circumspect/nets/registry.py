"""Every network by name."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any

import torch
from torch import nn

from circumspect.classification import GridRecipe, InputRecipe, PointsRecipe
from circumspect.classification.context import WIDTH
from circumspect.errors import CircumspectError, InputError, WeightsError, printable
from circumspect.nets.deeppano import DeepPano
from circumspect.nets.headed_planes import HeadedPlanes
from circumspect.nets.moon2018 import Moon2018
from circumspect.nets.mvcnn import MultiView
from circumspect.nets.planes import Planes
from circumspect.nets.pointmlp import PointMLP
from circumspect.nets.pointnet import PointNet
from circumspect.nets.shapenets import ShapeNets
from circumspect.nets.voxelnet import VoxelNet
from circumspect.nets.voxnet import VoxNet
from circumspect.plugins import (
    PLUGIN_NAME,
    REFERENCE,
    PluginError,
    Registry,
    cause_of,
    kind_of,
)

MARGIN = 1.1
"""Of what is trained on objects of varied size; `docs/networks.md` says why."""
CYLINDER = GridRecipe(margin=MARGIN)
CUBE = GridRecipe("rectangular", margin=MARGIN)
SURFACE = PointsRecipe(8192, surface=True, margin=MARGIN)
"""Images of so many points still have holes, the more the larger an object's surface is."""
PLAIN: Mapping[str, Any] = MappingProxyType({"mixing": 0.0, "label_smoothing": 0.0})
AS_THE_PAPER: Mapping[str, Any] = MappingProxyType(
    {
        **PLAIN,
        "optimizer": "sgd", "learning_rate": 0.03, "weight_decay": 0.0, "averaging": 0.0,
        "balance": 0.0, "augmented": False, "replicas": 1, "epochs": 12,
    }
)  # fmt: skip
"""Plain stochastic gradient descent on the objects as they are; the paper names no epochs."""


@dataclass(frozen=True)
class NetSpec:
    """A network that can be built.

    Attributes:
        name: Its name on the command line.
        summary: What it is, in one line.
        build: Makes it from the number of classes and, where it takes grids, their shape.
        recipe: What it is meant to be shown.
        source: Where it comes from.
        departures: What differs from there, and what was decided where it is silent.
        training: Settings that it is meant to be trained with, where they differ from the usual.
        takes_context: It can be shown visibility and size, see `GridRecipe`.
        whole_cells: Its answer is the same for turns by whole azimuth cells of a 32nd of a turn.
        heading: It also learns which way objects face, so that all must face the same way.
    """

    name: str
    summary: str
    build: Callable[..., nn.Module]
    recipe: InputRecipe = field(default_factory=GridRecipe)
    source: str = "ours"
    departures: str = ""
    training: Mapping[str, Any] = field(default_factory=dict)
    takes_context: bool = False
    whole_cells: bool = False
    heading: bool = False


_MOON = "Moon, Kim and Lee 2018"
_DECIDED = (
    "decided where the paper is silent: a momentum of 0.9, 12 epochs in batches of 32, a learning "
    "rate that rises to 0.03 and falls as a cosine, gradients shortened to a length of 5; objects "
    "are held back, and by them the best epoch is chosen; the grid's axis goes through the mean of "
    "the surface, every part by its area"
)
NETS = {
    spec.name: spec
    for spec in (
        NetSpec(
            "planes",
            "wrapped 2D convolutions on two stacks of planes, circular mixing, RWMP and mean",
            Planes,
            CYLINDER,
            takes_context=True,
            whole_cells=True,
        ),
        NetSpec(
            "headed-planes",
            "`planes`, narrower, that also learns which way the object faces",
            HeadedPlanes,
            CYLINDER,
            whole_cells=True,
            heading=True,
        ),
        NetSpec(
            "moon2018",
            "the paper's: four convolutions, row-wise max pooling (RWMP)",
            Moon2018,
            source=_MOON,
            departures=_DECIDED,
            training=AS_THE_PAPER,
        ),
        NetSpec(
            "moon2018-max",
            "the paper's comparison: 2x2x2 max pooling in the place of RWMP",
            partial(Moon2018, pool="max"),
            source=_MOON,
            departures=f"{_DECIDED}; the pooling is of 2x2x2 cells with a stride of 2",
            training=AS_THE_PAPER,
        ),
        NetSpec(
            "voxnet",
            "two convolutions, pooling and one hidden layer on voxels",
            VoxNet,
            CUBE,
            "Maturana and Scherer 2015",
            "AdamW in the place of SGD; not trained on turned copies, no vote over them; "
            "surface cells only, not a density grid",
            {**PLAIN, "epochs": 40},
        ),
        NetSpec(
            "3dshapenets",
            "three convolutions and two hidden layers on voxels",
            ShapeNets,
            CUBE,
            "Wu et al. 2015",
            "feed-forward: the top layers are plain hidden ones, all is trained at once by "
            "back-propagation instead of layer by layer; 32 cells a side instead of 30, "
            "surface cells only",
            PLAIN,
        ),
        NetSpec(
            "deeppano",
            "convolutions on a panorama of the cylinder's surface, RWMP",
            DeepPano,
            SURFACE,
            "Shi et al. 2015",
            "narrower, with batch norms; wrapped at every convolution instead of padding the "
            "panorama once; rendered from points, which leaves holes",
            PLAIN,
        ),
        NetSpec(
            "mvcnn",
            "one network for 12 views, the largest of each feature over the views",
            MultiView,
            SURFACE,
            "Su et al. 2015",
            "small, with batch norms and without pre-trained weights; depth images of 64 x 64 "
            "pixels, rendered from points, which leaves holes, instead of shaded ones",
            PLAIN,
        ),
        NetSpec(
            "pointnet",
            "every point by itself, the largest of each feature over the points",
            PointNet,
            PointsRecipe(1024, margin=MARGIN),
            "Qi et al. 2017",
            "no loss on the feature transform; not trained on turned copies",
            {**PLAIN, "epochs": 30},
        ),
        NetSpec(
            "pointmlp",
            "four stages, each of anchors that gather the features of their nearest points",
            PointMLP,
            PointsRecipe(1024, margin=MARGIN, farthest_first=True),
            "Ma et al. 2022",
            "the small form of the paper, PointMLP-elite; every farthest point sample begins with "
            "the outermost point, not with a random one, so that those of all stages are parts of "
            "one order, which is made before the network; AdamW and 24 epochs in the place of SGD "
            "and 300; no vote over scaled copies; the authors' label smoothing of 0.2",
            {**PLAIN, "label_smoothing": 0.2},
        ),
        NetSpec(
            "voxelnet",
            "points encoded by cells of a cylindrical grid, wrapped convolutions, RWMP and mean",
            VoxelNet,
            SURFACE,
            "Zhou and Tuzel 2018",
            "the feature encoding alone is theirs; points are told by radius, height and where "
            "they lie in their cell, which forgets the azimuth; all points of a cell count",
            PLAIN,
        ),
    )
}


def _checked(name: str, value: Any) -> NetSpec:
    """What a plug-in offers, if it is a network.

    Raises:
        InputError: It is not.
    """
    if not isinstance(value, NetSpec):
        raise InputError(f"{kind_of(value)}; a circumspect.nets.NetSpec is needed")
    if not PLUGIN_NAME.fullmatch(str(value.name)):
        raise InputError(
            f"has the name {value.name!r:.40}; letters, digits, '-' and '_' are needed"
        )
    if value.name in NETS:
        raise InputError(f"has the name of the built-in network {value.name}; choose another")
    if not REFERENCE.fullmatch(name) and name != value.name:
        raise InputError(f"is named {value.name} by its NetSpec; give the entry point that name")
    if not callable(value.build) or not isinstance(value.recipe, InputRecipe):
        raise InputError("needs a callable `build` and an input specification as `recipe`")
    return value


NETWORKS = Registry("network", "circumspect.nets", NETS, _checked)
"""The networks above, and those of other packages."""
_REFERENCES: dict[str, str] = {}
"""Name to MODULE:NAME of the networks that were asked for by it."""


def net_spec(name: str) -> NetSpec:
    """Look a network up.

    Args:
        name: One of `NETS`, an entry point of the group `circumspect.nets`, or MODULE:NAME of a
            `NetSpec`, which is known by its own name from then on.

    Raises:
        InputError: No network of that name.
        PluginError: There is one, but it can not be used.
    """
    spec = NETWORKS.get(name)
    if REFERENCE.fullmatch(name):
        NETWORKS.remember(spec.name, spec)
        _REFERENCES[spec.name] = name
    return spec


def net_words(name: str) -> str:
    """What to type for a network: its name, or MODULE:NAME where it was asked for by that."""
    return _REFERENCES.get(name, name)


def require_known(name: str, file: str | os.PathLike[str]) -> None:
    """Check a network that a file names; no code of its choice is imported.

    Args:
        name: As the file says.
        file: For the message.

    Raises:
        WeightsError: No network of that name is known.
        PluginError: There is one, but it can not be used.
    """
    if NETWORKS.find(name, reference=False) is None:
        raise WeightsError(
            f"{file}: made with the network '{printable(name[:80])}', which is not installed; name "
            "its code: --net MODULE:NAME"
        )


def build_net(name: str, classes: int, recipe: InputRecipe) -> nn.Module:
    """Build a network with fresh weights, laid out as CPU convolutions like them best.

    Args:
        name: One of `NETS`.
        classes: How many.
        recipe: What it will be shown.

    Raises:
        InputError: No network of that name, or it can not be shown that.
    """
    spec = net_spec(name)
    if isinstance(recipe, PointsRecipe) != isinstance(spec.recipe, PointsRecipe):
        takes = "points" if isinstance(spec.recipe, PointsRecipe) else "grids"
        raise InputError(f"{name} takes {takes}")
    cells = (recipe.shape,) if isinstance(recipe, GridRecipe) else ()
    beside = _beside(spec, recipe)
    net = (
        spec.build(classes, *cells, **beside)
        if spec.name in NETS
        else _built_by_plugin(spec, classes, recipe, cells, beside)
    )
    layouts = {4: torch.channels_last, 5: torch.channels_last_3d}
    for parameter in net.parameters():
        if layout := layouts.get(parameter.ndim):
            parameter.data = parameter.data.contiguous(memory_format=layout)
    return net


def _built_by_plugin(
    spec: NetSpec,
    classes: int,
    recipe: InputRecipe,
    cells: tuple[tuple[int, int, int], ...],
    beside: Mapping[str, int],
) -> nn.Module:
    """A network of foreign code, which gives a score of each class for each input.

    Raises:
        PluginError: It can not be built, or gives something else.
    """
    title = f"network '{spec.name}'"
    try:
        net = spec.build(classes, *cells, **beside)
        if not isinstance(net, nn.Module):
            raise PluginError(f"{title}: what it builds {kind_of(net)}; a torch Module is needed")
        context = (torch.zeros(2, beside["context"]),) if beside else ()
        channels = beside.get("channels", recipe.input_shape[0])
        shape = (channels, *recipe.input_shape[1:]) if cells else recipe.input_shape
        training = net.training
        with torch.no_grad():
            scores = net.eval()(torch.zeros(2, *shape), *context)
        net.train(training)
    except CircumspectError:
        raise
    except Exception as error:
        raise PluginError(f"{title} can not be built or run: {cause_of(error)}") from error
    found = tuple(scores.shape) if isinstance(scores, torch.Tensor) else kind_of(scores)
    if found != (2, classes):
        raise PluginError(
            f"{title}: of two inputs of shape {shape} and {classes} classes it makes {found}, not "
            f"scores of shape (2, {classes})"
        )
    return net


def _beside(spec: NetSpec, recipe: InputRecipe) -> dict[str, int]:
    """What a network is shown beside occupied cells."""
    if not recipe.takes_context:
        return {}
    if not spec.takes_context:
        raise InputError(f"{spec.name} takes occupancy alone, neither visibility nor size")
    visible = isinstance(recipe, GridRecipe) and recipe.visibility
    return {"channels": 2 if visible else 1, "context": WIDTH}


def require_takes(name: str, recipe: InputRecipe) -> None:
    """Find out before long work whether a network can be shown such inputs.

    Args:
        name: One of `NETS`.
        recipe: What it would be shown.

    Raises:
        InputError: No network of that name, or it can not be shown that.
    """
    if net_spec(name).name not in NETS:
        # Foreign code need not run without numbers.
        build_net(name, 2, recipe)
        return
    # Shapes without numbers: the largest of them have millions.
    with torch.device("meta"):
        build_net(name, 2, recipe)


def require_turnable(name: str) -> None:
    """Find out before long work whether a network can be trained at random yaw.

    Args:
        name: One of `NETS`.

    Raises:
        InputError: No network of that name, or it learns which way objects face.
    """
    if net_spec(name).heading:
        raise InputError(
            f"{name} learns which way objects face, so it trains at 0° alone; leave out the "
            "random yaw"
        )
