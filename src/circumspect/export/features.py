"""A second output of ONNX networks: the features before the last linear layer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper

from circumspect.classification import Classifier
from circumspect.classification.network_outputs import FEATURES
from circumspect.errors import CircumspectError, WeightsError
from circumspect.storage import atomic_path

LOGITS = "logits"
_LINEAR = ("Gemm", "MatMul")
_CONVOLUTIONS = ("Conv", "ConvTranspose")


def add_features(network: onnx.ModelProto) -> bool:
    """Add the features of a network as second output; the logits stay bit-identical.

    Features are the input of the last linear layer; in a committee, those of all members side by
    side, so that the logits are linear in them.

    Args:
        network: With the output `logits`; changed in place.

    Returns:
        Whether it has features now: a network whose last layer is not linear does not.
    """
    graph = network.graph
    if any(output.name == FEATURES for output in graph.output):
        return True
    weights = {tensor.name: tuple(tensor.dims) for tensor in graph.initializer}
    layers = _last_layers(graph, weights)
    if not layers:
        return False
    width = sum(_inputs_of(layer, weights) for layer in layers)
    names = [layer.input[0] for layer in layers]
    if len(names) == 1:
        graph.node.append(helper.make_node("Identity", names, [FEATURES], name=FEATURES))
    else:
        graph.node.append(helper.make_node("Concat", names, [FEATURES], name=FEATURES, axis=-1))
    objects = graph.input[0].type.tensor_type.shape.dim[0].dim_param
    output = helper.make_tensor_value_info(FEATURES, TensorProto.FLOAT, [objects or None, width])
    graph.output.append(output)
    onnx.checker.check_model(network)
    return True


def write_with_features(weights: Path, out: Path) -> None:
    """Complete a file that was exported without features.

    Args:
        weights: A classifier; it may be `out` itself.
        out: The file to write.

    Raises:
        WeightsError: No classifier, or its last layer is not linear.
        CircumspectError: The new file gives other answers; it is not kept.
        OutputError: The file cannot be written.
    """
    Classifier.load(weights)
    before = weights.read_bytes()
    network = onnx.load_from_string(before)
    if not add_features(network):
        raise WeightsError(f"{weights}: has no linear last layer, so no features to give")
    after = network.SerializeToString()
    if not np.array_equal(_answers(before), _answers(after)):
        raise CircumspectError(f"{out}: not kept, its answers differ from those of {weights}")
    with atomic_path(out) as temporary:
        temporary.write_bytes(after)


def _answers(content: bytes) -> np.ndarray:
    """Logits of random input, sparse and dense."""
    session = onnxruntime.InferenceSession(content, providers=["CPUExecutionProvider"])
    given = session.get_inputs()[0]
    rng = np.random.default_rng(0)
    shape = (8, *given.shape[1:])
    density = np.linspace(0.0, 1.0, 8).reshape(-1, *[1] * (len(shape) - 1)) ** 3
    if given.type == "tensor(uint8)":
        values = (rng.random(shape) < density).astype(np.uint8)
    else:
        values = rng.uniform(-0.7, 0.7, shape).astype(np.float32)
    return np.asarray(session.run([LOGITS], {given.name: values})[0])


def _last_layers(
    graph: onnx.GraphProto, weights: dict[str, tuple[int, ...]]
) -> list[onnx.NodeProto]:
    """The linear layers before the logits, one per member of a committee; or none."""
    made_by = {name: node for node in graph.node for name in node.output}
    found: list[onnx.NodeProto] = []
    waiting = [LOGITS]
    while waiting:
        node = made_by.get(waiting.pop(0))
        if node is None:
            continue
        if node.op_type in _CONVOLUTIONS:
            return []
        if node.op_type in _LINEAR and len(weights.get(node.input[1], ())) == 2:
            found.append(node)
        else:
            waiting += node.input
    return found


def _inputs_of(layer: onnx.NodeProto, weights: dict[str, tuple[int, ...]]) -> int:
    """Number of inputs of a linear layer."""
    transposed = any(a.name == "transB" and a.i for a in layer.attribute)
    return weights[layer.input[1]][1 if transposed else 0]
