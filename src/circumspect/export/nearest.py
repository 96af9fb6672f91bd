"""The training objects as part of an ONNX network: an output is the distance to the nearest one.

An object far from all training objects is out of distribution, whatever its label (Sun, Ming, Zhu
and Li, "Out-of-distribution detection with deep nearest neighbors", ICML 2022).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from circumspect.classification import Classifier, ExampleTable
from circumspect.classification.model_description import checked_distance
from circumspect.classification.network_outputs import DISTANCE, FEATURES
from circumspect.errors import WeightsError
from circumspect.export.description import describe
from circumspect.storage import atomic_path

OURS = "nearest_"
"""Prefix of the names of these nodes and weights."""


def write_with_distance(path: Path, examples: ExampleTable, unknown_beyond: float | None) -> None:
    """Add the training objects to a file; its answers stay.

    Args:
        path: A classifier that gives its features.
        examples: Features of its training objects.
        unknown_beyond: Objects farther than this from all of them are called unknown, 0 … 2; None
            keeps what the file says.

    Raises:
        InputError: The distance is out of range.
        WeightsError: No classifier, or it gives no features.
        OutputError: The file cannot be written.
    """
    classifier = Classifier.load(path)
    if not classifier.gives_features:
        raise WeightsError(f"{path}: gives no features to compare; export it again")
    network = onnx.load_from_string(path.read_bytes())
    add_distance(network, examples)
    if unknown_beyond is not None:
        beyond = checked_distance(unknown_beyond)
        describe(network, {**classifier.description, "unknown_beyond": beyond})
    with atomic_path(path) as temporary:
        temporary.write_bytes(network.SerializeToString())


def add_distance(network: onnx.ModelProto, examples: ExampleTable) -> None:
    """Add the distance to the nearest example as an output of a network.

    It replaces an earlier one. Distances are 1 - cos of the angle between features, as in
    `NearExample`.

    Args:
        network: With the output `features`; changed in place.
        examples: The table.
    """
    graph = network.graph
    _remove(graph)
    directions = examples.directions.T.astype(np.float16)
    weights = {"examples": directions, "one": np.ones(1, np.float32), "last": np.array([-1])}
    graph.initializer.extend(
        numpy_helper.from_array(value, f"{OURS}{name}") for name, value in weights.items()
    )
    # Half precision keeps the file small; ONNX Runtime unpacks it once, when it loads the file.
    _append(graph, "Cast", ["examples"], "unpacked", to=TensorProto.FLOAT)
    _append(graph, "LpNormalization", [FEATURES], "direction", axis=-1, p=2)
    _append(graph, "MatMul", ["direction", "unpacked"], "cosines")
    _append(graph, "ReduceMax", ["cosines", "last"], "largest", keepdims=1)
    _append(graph, "Sub", ["one", "largest"], "apart")
    _append(graph, "Relu", ["apart"], DISTANCE)
    objects = graph.input[0].type.tensor_type.shape.dim[0].dim_param
    output = helper.make_tensor_value_info(DISTANCE, TensorProto.FLOAT, [objects or None, 1])
    graph.output.append(output)
    onnx.checker.check_model(network)


def _append(
    graph: onnx.GraphProto, kind: str, inputs: list[str], output: str, **attributes: Any
) -> None:
    outside = (FEATURES, DISTANCE)
    names = [name if name in outside else f"{OURS}{name}" for name in (*inputs, output)]
    node = helper.make_node(kind, names[:-1], names[-1:], name=f"{OURS}{kind}", **attributes)
    graph.node.append(node)


def _remove(graph: onnx.GraphProto) -> None:
    nodes = [node for node in graph.node if not node.name.startswith(OURS)]
    weights = [tensor for tensor in graph.initializer if not tensor.name.startswith(OURS)]
    outputs = [output for output in graph.output if output.name != DISTANCE]
    del graph.node[:], graph.initializer[:], graph.output[:]
    graph.node.extend(nodes)
    graph.initializer.extend(weights)
    graph.output.extend(outputs)
