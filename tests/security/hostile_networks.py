"""Malicious ONNX files."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from circumspect.classification import Classifier
from circumspect.classification.model_description import METADATA_KEY

HUGE = np.array([40_000, 100_000, 1])
ANSWERS_NOTHING = [
    helper.make_node("Cast", ["grid"], ["f"], to=TensorProto.FLOAT),
    helper.make_node("ReduceMean", ["f", "axes"], ["m"], keepdims=0),
    helper.make_node("Unsqueeze", ["m", "one"], ["u"]),
    helper.make_node("Expand", ["u", "shape"], ["e"]),
]
CONSTANTS = [
    numpy_helper.from_array(np.array([1, 2, 3, 4]), "axes"),
    numpy_helper.from_array(np.array([1]), "one"),
    numpy_helper.from_array(np.array([1, 10]), "shape"),
]


GRID = helper.make_tensor_value_info("grid", TensorProto.UINT8, ["objects", 1, 32, 32, 32])


def network(nodes: list[onnx.NodeProto], constants=(), opsets=()) -> onnx.ModelProto:
    output = helper.make_tensor_value_info("logits", TensorProto.FLOAT, ["objects", 10])
    graph = helper.make_graph(
        [*ANSWERS_NOTHING, *nodes], "g", [GRID], [output], [*CONSTANTS, *constants]
    )
    return described(graph, opsets)


def described(graph: onnx.GraphProto, opsets=()) -> onnx.ModelProto:
    """With the description of `modelnet10`."""
    made = helper.make_model(
        graph, opset_imports=[helper.make_opsetid("", 18), *opsets], ir_version=10
    )
    entry = made.metadata_props.add()
    entry.key, entry.value = METADATA_KEY, json.dumps(Classifier.load("modelnet10").description)
    return made


def summed(name: str) -> list[onnx.NodeProto]:
    return [
        helper.make_node("ReduceSum", [name], ["sum"], keepdims=0),
        helper.make_node("Add", ["e", "sum"], ["logits"]),
    ]


def harmless() -> onnx.ModelProto:
    return network([helper.make_node("Identity", ["e"], ["logits"])])


def expands() -> onnx.ModelProto:
    big = numpy_helper.from_array(HUGE, "huge")
    return network([helper.make_node("Expand", ["m", "huge"], ["z"]), *summed("z")], [big])


def fills() -> onnx.ModelProto:
    big = numpy_helper.from_array(HUGE, "huge")
    return network([helper.make_node("ConstantOfShape", ["huge"], ["z"]), *summed("z")], [big])


def doubles() -> onnx.ModelProto:
    names = ["f", *(f"twice{n}" for n in range(18))]
    pairs = itertools.pairwise(names)
    nodes = [helper.make_node("Concat", [a, a], [b], axis=1) for a, b in pairs]
    return network([*nodes, *summed(names[-1])])


def answers_of_another_shape() -> onnx.ModelProto:
    shape = numpy_helper.from_array(np.array([3, 10]), "other")
    return network([helper.make_node("Expand", ["e", "other"], ["logits"])], [shape])


def loops() -> onnx.ModelProto:
    body = helper.make_graph(
        [helper.make_node("Identity", [a], [b]) for a, b in (("c", "c2"), ("s", "s2"))],
        "b",
        [
            helper.make_tensor_value_info("i", TensorProto.INT64, []),
            helper.make_tensor_value_info("c", TensorProto.BOOL, []),
            helper.make_tensor_value_info("s", TensorProto.FLOAT, []),
        ],
        [
            helper.make_tensor_value_info("c2", TensorProto.BOOL, []),
            helper.make_tensor_value_info("s2", TensorProto.FLOAT, []),
        ],
    )
    constants = [
        numpy_helper.from_array(np.array(2**62), "times"),
        numpy_helper.from_array(np.array(True), "on"),
        numpy_helper.from_array(np.array(0, np.float32), "zero"),
    ]
    nodes = [
        helper.make_node("Loop", ["times", "on", "zero"], ["sum"], body=body),
        helper.make_node("Add", ["e", "sum"], ["logits"]),
    ]
    return network(nodes, constants)


def reads_another_file() -> onnx.ModelProto:
    weights = TensorProto(name="w", data_type=TensorProto.FLOAT, dims=[10], data_location=1)
    for key, value in (("location", "passwords"), ("length", "40")):
        entry = weights.external_data.add()
        entry.key, entry.value = key, value
    return network([helper.make_node("Add", ["e", "w"], ["logits"])], [weights])


def hides_another_file_in_a_node() -> onnx.ModelProto:
    made = reads_another_file()
    weights = made.graph.initializer.pop()
    node = helper.make_node("Constant", [], ["w"])
    attribute = node.attribute.add()
    attribute.name, attribute.type = "value", onnx.AttributeProto.TENSOR
    attribute.t.CopyFrom(weights)
    made.graph.node.insert(0, node)
    return made


def calls_another_library() -> onnx.ModelProto:
    nodes = [helper.make_node("Run", ["e"], ["logits"], domain="evil")]
    return network(nodes, opsets=[helper.make_opsetid("evil", 1)])


def brings_functions() -> onnx.ModelProto:
    made = harmless()
    nodes = [helper.make_node("Identity", ["x"], ["y"])]
    made.functions.append(
        helper.make_function("", "Same", ["x"], ["y"], nodes, [helper.make_opsetid("", 18)])
    )
    return made


def is_sparse() -> onnx.ModelProto:
    made = network(summed("w"))
    values = numpy_helper.from_array(np.ones(1, np.float32), "w")
    places = numpy_helper.from_array(np.array([0]), "places")
    made.graph.sparse_initializer.append(helper.make_sparse_tensor(values, places, [4_000_000_000]))
    return made


def gives_one_number() -> onnx.ModelProto:
    output = helper.make_tensor_value_info("logits", TensorProto.FLOAT, [])
    nodes = [ANSWERS_NOTHING[0], helper.make_node("ReduceSum", ["f"], ["logits"], keepdims=0)]
    return described(helper.make_graph(nodes, "g", [GRID], [output]))


def gives_a_list() -> onnx.ModelProto:
    output = helper.make_tensor_sequence_value_info("logits", TensorProto.FLOAT, None)
    nodes = [ANSWERS_NOTHING[0], helper.make_node("SequenceConstruct", ["f"], ["logits"])]
    return described(helper.make_graph(nodes, "g", [GRID], [output]))


def takes_nothing() -> onnx.ModelProto:
    output = helper.make_tensor_value_info("logits", TensorProto.FLOAT, [1, 10])
    always = numpy_helper.from_array(np.zeros((1, 10), np.float32), "always")
    nodes = [helper.make_node("Identity", ["always"], ["logits"])]
    return described(helper.make_graph(nodes, "g", [], [output], [always]))


def takes_two_things() -> onnx.ModelProto:
    made = network([helper.make_node("Add", ["e", "more"], ["logits"])])
    more = helper.make_tensor_value_info("more", TensorProto.FLOAT, ["objects", 10])
    made.graph.input.append(more)
    return made


def gives_nothing() -> onnx.ModelProto:
    return described(helper.make_graph([ANSWERS_NOTHING[0]], "g", [GRID], []))


REFUSED: dict[str, tuple[Callable[[], onnx.ModelProto], str]] = {
    "loops": (loops, "loops or branches"),
    "reads another file": (reads_another_file, "another file"),
    "hides it in a node": (hides_another_file_in_a_node, "another file"),
    "calls another library": (calls_another_library, "another library"),
    "brings functions": (brings_functions, "functions"),
    "is sparse": (is_sparse, "sparse"),
    "gives one number": (gives_one_number, "not a row of scores"),
    "gives a list": (gives_a_list, "not a row of scores"),
    "gives nothing": (gives_nothing, "gives 0 outputs"),
    "takes nothing": (takes_nothing, "takes 0 inputs"),
    "takes two things": (takes_two_things, "takes 2 inputs"),
}
FAILING: dict[str, Callable[[], onnx.ModelProto]] = {
    "expands": expands,
    "fills": fills,
    "doubles": doubles,
    "another shape": answers_of_another_shape,
}
