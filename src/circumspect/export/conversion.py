"""Networks of PyTorch as ONNX."""

from __future__ import annotations

import logging

import onnx
import torch
from torch import nn

from circumspect.classification import InputRecipe, PointsRecipe
from circumspect.export.features import LOGITS
from circumspect.export.shown import Shown
from circumspect.geometry.ignored_warnings import ignored_warnings

OPSET = 18


def as_onnx(net: nn.Module, probe: Shown, recipe: InputRecipe) -> onnx.ModelProto:
    """The graph of a network, for any number of objects.

    Args:
        net: Takes inputs as they are stored.
        probe: Two inputs or more.
        recipe: What the inputs are.
    """
    examples = tuple(torch.from_numpy(array[:2]) for array in probe.arrays)
    names = [_input_name(recipe), "context"][: len(examples)]
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
    _forget_sources(network)
    return network


def _forget_sources(network: onnx.ModelProto) -> None:
    """Drop the exporter's notes on each node: they name the files it ran from."""
    for node in network.graph.node:
        del node.metadata_props[:]
        node.doc_string = ""
    for value in (*network.graph.value_info, *network.graph.input, *network.graph.output):
        del value.metadata_props[:]
    network.doc_string = ""
    network.graph.doc_string = ""
    del network.graph.metadata_props[:]


def _input_name(recipe: InputRecipe) -> str:
    return "points" if isinstance(recipe, PointsRecipe) else "grid"
