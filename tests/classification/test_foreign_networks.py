"""ONNX networks of other programs, described by an input specification."""

import json
import pickle
from itertools import permutations

import numpy as np
import onnx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import TensorProto, helper, numpy_helper
from two_kinds import flat_and_tall

from circumspect.classification import Classifier, GridSpec
from circumspect.cli.main import main
from circumspect.datasets import ObjectSet
from circumspect.datasets.point_pack import write_point_pack
from circumspect.errors import InputError, WeightsError
from circumspect.geometry import write_ply

AXES = "NCXYZ"
LENGTHS = {"N": "batch", "C": 1, "X": 8, "Y": 8, "Z": 6}
SHAPE = [8, 8, 6]
SPEC = {"classes": ["flat", "tall"], "input": {"kind": "rectangular", "shape": SHAPE}}


def weights():
    """Cells near the middle speak for what is flat, those above and below for what is tall."""
    height = np.abs(np.arange(6) - 2.5)
    tall = np.broadcast_to(height - 1.4, SHAPE)
    return np.stack([-tall, tall], axis=-1).astype(np.float32)


def save(path, layout=AXES, *, last="logits", kind=TensorProto.FLOAT, batch="batch", outputs=2):
    """A network of one matrix, whose input has its axes in any order."""
    space = [axis for axis in layout if axis not in "NC"]
    matrix = np.transpose(weights(), [*("XYZ".index(axis) for axis in space), 3])[..., :outputs]
    rows = matrix.reshape(-1, outputs)
    nodes = [
        helper.make_node("Cast", ["voxels"], ["cast"], to=TensorProto.FLOAT),
        # N first, the rest in its order.
        helper.make_node(
            "Transpose", ["cast"], ["moved"],
            perm=[layout.index("N"), *(i for i, axis in enumerate(layout) if axis != "N")],
        ),
        helper.make_node("Reshape", ["moved", "rows"], ["flat"]),
        helper.make_node("MatMul", ["flat", "matrix"], ["logits"]),
        helper.make_node("Softmax", ["logits"], ["shares"], axis=1),
    ]  # fmt: skip
    lengths = {**LENGTHS, "N": batch}
    taken = helper.make_tensor_value_info("voxels", kind, [lengths[axis] for axis in layout])
    names = [last] if isinstance(last, str) else last
    given = [helper.make_tensor_value_info(n, TensorProto.FLOAT, [batch, outputs]) for n in names]
    constants = [
        numpy_helper.from_array(np.array([-1, len(rows)]), "rows"),
        numpy_helper.from_array(rows, "matrix"),
    ]
    graph = helper.make_graph(nodes, "g", [taken], given, constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)
    onnx.save(model, path)
    return path


def describe(network, *, beside=".input.json", **changes):
    document = {key: value for key, value in {**SPEC, **changes}.items() if value is not None}
    path = network.with_name(network.stem + beside)
    path.write_text(json.dumps(document))
    return path


def clouds(count=6):
    objects = flat_and_tall(count)
    return [objects.cloud(index) for index in range(count)], objects.labels


def shares(classifier):
    return np.array([list(classifier.classify(one).probabilities.values()) for one in clouds()[0]])


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    network = save(tmp_path_factory.mktemp("plain") / "net.onnx")
    describe(network)
    return shares(Classifier.load(network))


LAYOUTS = ["".join(p) for axes in ("NCXYZ", "NXYZ") for p in permutations(axes)]


@settings(max_examples=12, deadline=None)
@given(st.sampled_from(LAYOUTS), st.sampled_from(["uint8", "float", "bool", "float16", "int64"]))
def test_any_order_of_axes_and_any_type_give_the_same_answers(
    tmp_path_factory, expected, layout, kind
):
    kinds = {"float": 1, "uint8": 2, "int64": 7, "bool": 9, "float16": 10}
    network = save(tmp_path_factory.mktemp("net") / "net.onnx", layout, kind=kinds[kind])
    describe(network, input={**SPEC["input"], "layout": layout})
    assert np.allclose(shares(Classifier.load(network)), expected, atol=1e-5)


def test_network_names_flat_and_tall_objects(tmp_path):
    network = save(tmp_path / "net.onnx")
    describe(network)
    classifier = Classifier.load(network)
    found, labels = clouds()
    assert [classifier.classify(one).label for one in found] == [
        ("flat", "tall")[label] for label in labels
    ]
    assert classifier.input_spec == GridSpec("rectangular", (8, 8, 6))
    copy = pickle.loads(pickle.dumps(classifier))
    assert np.array_equal(shares(copy), shares(classifier))


def test_probabilities_are_taken_as_such(tmp_path, expected):
    network = save(tmp_path / "net.onnx", last="shares")
    describe(network, output={"values": "probabilities"})
    assert np.allclose(shares(Classifier.load(network)), expected, atol=1e-5)


def test_network_of_single_inputs_is_run_on_many(tmp_path, expected):
    network = save(tmp_path / "net.onnx", batch=1)
    describe(network)
    classifier = Classifier.load(network)
    inputs = np.stack([classifier.input_spec.inputs(one)[0] for one in clouds()[0]])
    assert np.allclose(classifier.probabilities(inputs), expected, atol=1e-5)


def test_output_is_chosen_by_name(tmp_path, expected):
    network = save(tmp_path / "net.onnx", last=["shares", "logits"])
    describe(network)
    with pytest.raises(WeightsError, match=r"has the outputs 'shares', 'logits'; name one by outp"):
        Classifier.load(network)
    describe(network, output={"name": "logits"})
    assert np.allclose(shares(Classifier.load(network)), expected, atol=1e-5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"classes": ["a", "b", "c"]}, r"'logits' has the shape \['batch', 2\], but 3 classes"),
        ({"classes": ["a", "a"]}, "classes are not distinct"),
        ({"classes": None}, "'classes' is missing"),
        ({"input": None}, "'input' is missing"),
        ({"input": {"kind": "rectangular", "shape": [8, 9, 6]}}, "axis Y of the input 'voxels'"),
        ({"input": {"kind": "round"}}, "a grid is cylindrical or rectangular, not 'round'"),
        ({"input": {"shape": SHAPE}}, "'kind' is missing; one of cylindrical, rectangular, points"),
        ({"input": {**SPEC["input"], "name": "x"}}, "has no input 'x'; its inputs: 'voxels'"),
        ({"input": {**SPEC["input"], "layout": "NXYZ"}}, "has 5 axes .* input.layout NXYZ has 4"),
        ({"input": {**SPEC["input"], "layout": "NCXYY"}}, "each of N, C, X, Y, Z once; C may be"),
        ({"input": {**SPEC["input"], "layout": 3}}, "input.layout must hold"),
        ({"input": {**SPEC["input"], "margin": 0.5}}, "margin must be a number from 1 to 4"),
        ({"input": {**SPEC["input"], "cells": 3}}, r"unknown settings \['cells'\]"),
        ({"input": {"kind": "points", "count": 64}}, "has 5 axes .* input.layout NPC has 3"),
        (
            {"input": {"kind": "cylindrical", "metric": True}},
            "visibility and metric are for networks of circumspect",
        ),
        ({"output": {"name": "y"}}, "has no output 'y'; its outputs: 'logits'"),
        ({"output": {"values": "odds"}}, "must be logits or probabilities, not 'odds'"),
        ({"output": {"values": "probabilities"}}, "those are no probabilities: say output.values"),
        ({"output": {"temperature": 0}}, "temperature must be a positive number"),
        ({"output": []}, "'output' must be a table"),
        ({"extra": 1}, "unknown entry 'extra'; known: classes, other, input, output"),
        ({"other": "lamp"}, "class of other things, 'lamp', is none of its classes"),
    ],
)
def test_mismatch_is_named(tmp_path, capsys, changes, message):
    network = save(tmp_path / "net.onnx")
    describe(network, **changes)
    with pytest.raises(InputError, match=message) as caught:
        Classifier.load(network)
    assert "net." in str(caught.value)
    assert main(["classify", "x.ply", "--model", str(network)]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize("text", ["", "{", "[1]", "[" * 5000, '{"classes": "ab"', "\xff"])
def test_a_broken_specification_is_refused(tmp_path, text):
    network = save(tmp_path / "net.onnx")
    (tmp_path / "net.input.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=r"net\.input\.json: "):
        Classifier.load(network)


def test_network_without_specification_is_refused_with_the_remedy(tmp_path):
    network = save(tmp_path / "net.onnx")
    with pytest.raises(
        WeightsError, match=r"describe its input in net\.input\.toml or net\.input\.j"
    ):
        Classifier.load(network)
    describe(network)
    describe(network, beside=".input.toml")
    with pytest.raises(InputError, match=r"net\.input\.json lies beside it; remove one"):
        Classifier.load(network)


def test_specification_of_a_network_that_needs_none_is_refused(tmp_path):
    spec = describe(save(tmp_path / "net.onnx"))
    with pytest.raises(InputError, match="'robot' needs no input specification"):
        Classifier.load("robot", input_spec=spec)
    with pytest.raises(InputError, match=r"elsewhere\.toml: no such file"):
        Classifier.load(tmp_path / "net.onnx", input_spec=tmp_path / "elsewhere.toml")


def test_export_keeps_the_network_unchanged(tmp_path, capsys):
    network = save(tmp_path / "net.onnx")
    describe(network)
    assert main(["export", str(network), str(tmp_path / "new.onnx")]) == 2
    assert "of another program, which is used as it is" in capsys.readouterr().err


def test_classify_and_evaluate_take_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    network, elsewhere = save(tmp_path / "net.onnx"), tmp_path / "about.toml"
    elsewhere.write_text(
        'classes = ["flat", "tall"]\n'
        '[input]\nkind = "rectangular"\nshape = [8, 8, 6]\nlayout = "NCXYZ"\nname = "voxels"\n'
        '[output]\nvalues = "logits"\n'
    )
    write_ply("tall.ply", clouds()[0][1])
    flags = ["--model", str(network), "--input-spec", str(elsewhere), "--json"]
    assert main(["classify", "tall.ply", *flags]) == 0
    assert json.loads(capsys.readouterr().out)["label"] == "tall"
    objects = flat_and_tall(6)
    for split in ("train", "test"):
        names = np.array([f"{split}_{name}" for name in objects.names])
        pack = ObjectSet(objects.points_xyz, objects.labels, names, objects.classes)
        write_point_pack(tmp_path / f"{split}.npz", pack)
    assert main(["evaluate", "--data", ".", "--split", "test", "--yaw", "0,90", *flags]) == 0
    metrics = json.loads(capsys.readouterr().out)
    assert metrics["worst"] == 1.0
    assert len(metrics["input_spec_sha256"]) == 64
