"""The registry of networks."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any

import torch
from torch import nn

from circumspect.classification import GridSpec, InputSpec, PointsSpec
from circumspect.classification.context import WIDTH
from circumspect.errors import CircumspectError, InputError, WeightsError, printable
from circumspect.nets.deeppano import DeepPano
from circumspect.nets.moon2018 import Moon2018
from circumspect.nets.mvcnn import MultiView
from circumspect.nets.planes import HeadedPlanes, Planes
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
"""Margin for networks that are trained on objects of varying size; see `docs/networks.md`."""
CYLINDER = GridSpec(margin=MARGIN)
CUBE = GridSpec("rectangular", margin=MARGIN)
SURFACE = PointsSpec(8192, surface=True, margin=MARGIN)
"""Points for networks on images; fewer points leave holes, especially on large surfaces."""
PLAIN: Mapping[str, Any] = MappingProxyType({"mixing": 0.0, "label_smoothing": 0.0})
AS_THE_PAPER: Mapping[str, Any] = MappingProxyType(
    {
        **PLAIN,
        "optimizer": "sgd", "learning_rate": 0.03, "weight_decay": 0.0, "averaging": 0.0,
        "balance": 0.0, "augmented": False, "replicas": 1, "epochs": 12,
    }
)  # fmt: skip
"""Plain stochastic gradient descent without augmentation; the paper does not state the epochs."""


@dataclass(frozen=True)
class NetSpec:
    """Specification of a network.

    Attributes:
        name: Name on the command line.
        summary: One-line description.
        build: Builds the network from the number of classes and, if it takes grids, their shape.
        input_spec: Default input specification.
        source: Publication.
        departures: Differences from the publication, and choices that it leaves open.
        training: Training settings that differ from the default.
        takes_context: Whether it can take visibility and size, see `GridSpec`.
        whole_cells: Whether its answer is invariant to rotations by whole azimuth cells of a 32nd
            of a turn.
        heading: Whether it also learns the heading, which all training objects must then share.
    """

    name: str
    summary: str
    build: Callable[..., nn.Module]
    input_spec: InputSpec = field(default_factory=GridSpec)
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
            PointsSpec(1024, margin=MARGIN),
            "Qi et al. 2017",
            "no loss on the feature transform; not trained on turned copies",
            {**PLAIN, "epochs": 30},
        ),
        NetSpec(
            "pointmlp",
            "four stages, each of anchors that gather the features of their nearest points",
            PointMLP,
            PointsSpec(1024, margin=MARGIN, farthest_first=True),
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
            "the feature encoding alone is theirs; points are encoded by radius, height and where "
            "they lie in their cell, which forgets the azimuth; all points of a cell count",
            PLAIN,
        ),
    )
}


def _checked(name: str, value: Any) -> NetSpec:
    """Check that the object of a plug-in is a `NetSpec`.

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
    if not callable(value.build) or not isinstance(value.input_spec, InputSpec):
        raise InputError("needs a callable `build` and an input specification as `input_spec`")
    return value


NETWORKS = Registry("network", "circumspect.nets", NETS, _checked)
"""The built-in networks and those of other packages."""
_REFERENCES: dict[str, str] = {}
"""MODULE:NAME of the networks that were loaded by it, by name."""


def net_spec(name: str) -> NetSpec:
    """Look up a network by its name.

    Args:
        name: One of `NETS`, an entry point of the group `circumspect.nets`, or MODULE:NAME of a
            `NetSpec`, which is afterwards also available by its own name.

    Raises:
        InputError: There is no network of that name.
        PluginError: The network cannot be used.
    """
    spec = NETWORKS.get(name)
    if REFERENCE.fullmatch(name):
        NETWORKS.remember(spec.name, spec)
        _REFERENCES[spec.name] = name
    return spec


def net_words(name: str) -> str:
    """The name that loads a network: its own, or MODULE:NAME if it is not installed."""
    return _REFERENCES.get(name, name)


def require_known(name: str, file: str | os.PathLike[str]) -> None:
    """Check the network that a file names, without importing code that the file chooses.

    Args:
        name: Name of the network in the file.
        file: The file, for the message.

    Raises:
        WeightsError: There is no network of that name.
        PluginError: The network cannot be used.
    """
    if NETWORKS.find(name, reference=False) is None:
        raise WeightsError(
            f"{file}: made with the network '{printable(name[:80])}', which is not installed; name "
            "its code: --net MODULE:NAME"
        )


def build_net(name: str, classes: int, input_spec: InputSpec) -> nn.Module:
    """Build a network with new weights, in the memory layout that is fastest on a CPU.

    Args:
        name: One of `NETS`.
        classes: Number of classes.
        input_spec: Inputs of the network.

    Raises:
        InputError: There is no network of that name, or it does not take such inputs.
    """
    spec = net_spec(name)
    if isinstance(input_spec, PointsSpec) != isinstance(spec.input_spec, PointsSpec):
        takes = "points" if isinstance(spec.input_spec, PointsSpec) else "grids"
        raise InputError(f"{name} takes {takes}")
    cells = (input_spec.shape,) if isinstance(input_spec, GridSpec) else ()
    beside = _context_arguments(spec, input_spec)
    net = (
        spec.build(classes, *cells, **beside)
        if spec.name in NETS
        else _built_by_plugin(spec, classes, input_spec, cells, beside)
    )
    layouts = {4: torch.channels_last, 5: torch.channels_last_3d}
    for parameter in net.parameters():
        if layout := layouts.get(parameter.ndim):
            parameter.data = parameter.data.contiguous(memory_format=layout)
    return net


def _built_by_plugin(
    spec: NetSpec,
    classes: int,
    input_spec: InputSpec,
    cells: tuple[tuple[int, int, int], ...],
    beside: Mapping[str, int],
) -> nn.Module:
    """Build a network of third-party code, which must return one score per class and input.

    Raises:
        PluginError: It cannot be built, or returns something else.
    """
    title = f"network '{spec.name}'"
    try:
        net = spec.build(classes, *cells, **beside)
        if not isinstance(net, nn.Module):
            raise PluginError(f"{title}: what it builds {kind_of(net)}; a torch Module is needed")
        context = (torch.zeros(2, beside["context"]),) if beside else ()
        channels = beside.get("channels", input_spec.input_shape[0])
        shape = (channels, *input_spec.input_shape[1:]) if cells else input_spec.input_shape
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


def _context_arguments(spec: NetSpec, input_spec: InputSpec) -> dict[str, int]:
    """Arguments for the inputs in addition to occupied cells."""
    if not input_spec.takes_context:
        return {}
    if not spec.takes_context:
        raise InputError(f"{spec.name} takes occupancy alone, not visibility or size")
    visible = isinstance(input_spec, GridSpec) and input_spec.visibility
    return {"channels": 2 if visible else 1, "context": WIDTH}


def require_takes(name: str, input_spec: InputSpec) -> None:
    """Check before a long run that a network takes such inputs.

    Args:
        name: One of `NETS`.
        input_spec: The inputs.

    Raises:
        InputError: There is no network of that name, or it does not take such inputs.
    """
    if net_spec(name).name not in NETS:
        # Third-party code may not run on the meta device.
        build_net(name, 2, input_spec)
        return
    # The meta device computes only shapes; the largest inputs have millions of numbers.
    with torch.device("meta"):
        build_net(name, 2, input_spec)


def require_turnable(name: str) -> None:
    """Check before a long run that a network can be trained at random yaw.

    Args:
        name: One of `NETS`.

    Raises:
        InputError: There is no network of that name, or it learns the heading of objects.
    """
    if net_spec(name).heading:
        raise InputError(
            f"{name} learns which way objects face, so it trains at 0° alone; leave out the "
            "random yaw"
        )
