"""Conversion of PyTorch networks to ONNX networks that take inputs as they are stored."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from circumspect.classification import GridSpec, InputSpec, PointsSpec
from circumspect.export.features import LOGITS
from circumspect.geometry.formats.ignored_warnings import ignored_warnings
from circumspect.nets.state_channels import state_channels

OPSET = 18


def taking_stored_inputs(net: nn.Module, input_spec: InputSpec) -> nn.Module:
    """The network in evaluation mode, behind a layer that converts stored inputs to floats.

    Args:
        net: Takes what the input specification makes, as float32.
        input_spec: Of its inputs.
    """
    if input_spec.takes_context:
        assert isinstance(input_spec, GridSpec)
        return _StatesAsStored(net, input_spec.visibility).eval()
    return _AsStored(net).eval()


class _AsStored(nn.Module):
    """Takes grids as they are stored, uint8, and points as they are."""

    def __init__(self, net: nn.Module) -> None:
        super().__init__()
        self.net = net

    def forward(self, given: Tensor) -> Tensor:
        return self.net(given.float())


class _StatesAsStored(nn.Module):
    """Takes the states of cells as they are stored, uint8, and a context beside them."""

    def __init__(self, net: nn.Module, visibility: bool) -> None:
        super().__init__()
        self.net = net
        self.visibility = visibility

    def forward(self, given: Tensor, context: Tensor) -> Tensor:
        return self.net(state_channels(given) if self.visibility else given.float(), context)


@dataclass(frozen=True, eq=False)
class NetworkInputs:
    """Inputs of n objects, one view each.

    Attributes:
        inputs: (n, *input_shape).
        contexts: (n, 6) float32, or None.
    """

    inputs: NDArray[Any]
    contexts: NDArray[np.float32] | None = None

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """The arrays in the order of the network's inputs."""
        return (self.inputs,) if self.contexts is None else (self.inputs, self.contexts)

    def every_second(self, first: int) -> NetworkInputs:
        """Half of the objects, from the first or the second on."""
        contexts = None if self.contexts is None else self.contexts[first::2]
        return NetworkInputs(self.inputs[first::2], contexts)


def as_onnx(net: nn.Module, probe: NetworkInputs, input_spec: InputSpec) -> onnx.ModelProto:
    """The graph of a network, for any number of objects.

    Args:
        net: Takes inputs as they are stored.
        probe: Two inputs or more.
        input_spec: What the inputs are.
    """
    examples = tuple(torch.from_numpy(array[:2]) for array in probe.arrays)
    names = [_input_name(input_spec), "context"][: len(examples)]
    axes = {0: torch.export.Dim("objects")}
    exporter_log = logging.getLogger("torch.onnx")
    level = exporter_log.level
    exporter_log.setLevel(logging.ERROR)
    try:
        with ignored_warnings():
            program = torch.onnx.export(
                net,
                examples,
                input_names=names,
                output_names=[LOGITS],
                opset_version=OPSET,
                dynamo=True,
                dynamic_shapes=dict.fromkeys(("given", "context")[: len(examples)], axes),
                verbose=False,
            )
    finally:
        exporter_log.setLevel(level)
    assert program is not None
    network = program.model_proto
    _remove_sources(network)
    return network


def _remove_sources(network: onnx.ModelProto) -> None:
    """Drop the exporter's notes on each node: they name the files it ran from."""
    for node in network.graph.node:
        del node.metadata_props[:]
        node.doc_string = ""
    for value in (*network.graph.value_info, *network.graph.input, *network.graph.output):
        del value.metadata_props[:]
    network.doc_string = ""
    network.graph.doc_string = ""
    del network.graph.metadata_props[:]


def _input_name(input_spec: InputSpec) -> str:
    return "points" if isinstance(input_spec, PointsSpec) else "grid"
