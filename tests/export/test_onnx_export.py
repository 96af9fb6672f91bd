import json
from dataclasses import replace

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from network_inputs import small_input_spec, some_inputs, trained_looking

from circumspect.classification import Classifier, GridSpec, PointsSpec, input_spec_from_dict
from circumspect.classification.model_description import METADATA_KEY
from circumspect.errors import CircumspectError, InputError, WeightsError
from circumspect.export import export_onnx
from circumspect.export import onnx_export as fidelity_module
from circumspect.export.conversion import NetworkInputs
from circumspect.export.eight_bit import require_convolutions
from circumspect.export.features import write_with_features
from circumspect.furniture import make_furniture
from circumspect.nets import NETS, Checkpoint

pytestmark = pytest.mark.xdist_group("onnx_export")
"""One process for all: each conversion takes seconds, and they are shared."""
CLASSES = ("bed", "chair", "table")


def most_views(input_spec):
    return 1 if getattr(input_spec, "kind", None) == "rectangular" else 2


def checkpoint(name, seed=0):
    net = trained_looking(name, classes=len(CLASSES), seed=seed)
    return Checkpoint(name, CLASSES, small_input_spec(name), net.state_dict())


@pytest.fixture(scope="module")
def exports():
    """Files by the network's name: in whichever order the tests run, each is made once."""
    return {}


@pytest.fixture(params=NETS)
def exported(request, exports, tmp_path_factory):
    net = request.param
    if net not in exports:
        path, original = tmp_path_factory.mktemp("onnx") / "net.onnx", checkpoint(net)
        views = most_views(original.input_spec)
        export_onnx([original], path, azimuth_views=views, temperature=1.5)
        exports[net] = original, path
    return exports[net]


def test_outputs_equal_the_checkpoints(exported):
    original, path = exported
    inputs = some_inputs(original.input_spec, 5, seed=3)
    points = isinstance(original.input_spec, PointsSpec)
    given = {"points": inputs.numpy()} if points else {"grid": inputs.numpy().astype(np.uint8)}
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    (actual,) = session.run(["logits"], given)
    # PyTorch's single precision errs by more than the bound on some processors. The rounding of
    # images that a network draws belongs to its answer.
    precision = torch.float32 if original.net == "mvcnn" else torch.float64
    with torch.no_grad():
        expected = original.build().to(precision)(inputs.to(precision)).numpy()
    np.testing.assert_allclose(actual, expected, atol=1e-4)


@pytest.mark.parametrize(
    "exported", [name for name, spec in NETS.items() if spec.whole_cells], indirect=True
)
def test_the_exported_network_wraps_the_azimuth(exported):
    original, path = exported
    rng = np.random.default_rng(4)
    grid = (rng.random((1, 1, *original.input_spec.shape)) < 0.07).astype(np.uint8)
    rolls = np.concatenate([np.roll(grid, cells, axis=3) for cells in range(grid.shape[3])])
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    (logits,) = session.run(["logits"], {"grid": rolls})
    assert np.ptp(logits, axis=0).max() < 1e-4


def test_the_file_has_a_description_without_paths(exported):
    original, path = exported
    network = onnx.load(path)
    entry = {e.key: e.value for e in network.metadata_props}
    described = json.loads(entry[METADATA_KEY])
    assert described["classes"] == list(CLASSES)
    assert input_spec_from_dict(described["grid"]).azimuth_views == most_views(original.input_spec)
    assert described["temperature"] == 1.5
    assert b"circumspect/nets" not in path.read_bytes()
    assert b".py" not in path.read_bytes()


def test_loads_as_a_classifier(exported):
    _, path = exported
    classifier = Classifier.load(path)
    assert classifier.classes == CLASSES
    cloud = make_furniture("chair", 1).sampled(3000, 0)
    inputs = classifier.input_spec.inputs(cloud, [0.0, 1.0, 2.0])
    views = most_views(exported[0].input_spec)
    assert inputs.shape == (3, views, *classifier.input_spec.input_shape)
    np.testing.assert_allclose(classifier.probabilities(inputs).sum(axis=1), 1)
    assert classifier.classify(cloud).label in CLASSES


def test_a_file_that_answers_otherwise_is_not_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(fidelity_module, "TOLERANCE", 0.0)
    with pytest.raises(CircumspectError, match="not kept"):
        export_onnx([checkpoint("planes")], tmp_path / "net.onnx")
    assert list(tmp_path.iterdir()) == []


def test_a_committee_answers_with_the_mean_of_its_members(tmp_path):
    members = [checkpoint("planes", seed) for seed in (0, 1)]
    export_onnx(members, tmp_path / "committee.onnx", azimuth_views=2)
    rng = np.random.default_rng(6)
    grids = (rng.random((4, 1, *members[0].input_spec.shape)) < 0.07).astype(np.uint8)
    session = onnxruntime.InferenceSession(tmp_path / "committee.onnx")
    (actual,) = session.run(["logits"], {"grid": grids})
    with torch.no_grad():
        apart = [m.build()(torch.from_numpy(grids).float()).numpy() for m in members]
    assert np.abs(apart[0] - apart[1]).max() > 0.1
    np.testing.assert_allclose(actual, np.mean(apart, axis=0), atol=1e-4)
    assert Classifier.load(tmp_path / "committee.onnx").input_spec.azimuth_views == 2


@pytest.mark.parametrize(
    "change",
    [
        {"classes": ("bed", "chair", "sofa")},
        {"input_spec": GridSpec(fill_samples=100)},
        {"training": {"data": "another"}},
        {"training": {"settings": {"validation": False}}},
    ],
)
def test_members_of_a_committee_must_match(tmp_path, change):
    first = checkpoint("planes")
    with pytest.raises(InputError, match="must share"):
        export_onnx([first, replace(first, **change)], tmp_path / "net.onnx")
    with pytest.raises(InputError, match="no network"):
        export_onnx([], tmp_path / "net.onnx")


@pytest.fixture(scope="module")
def in_eight_bits(tmp_path_factory):
    path = tmp_path_factory.mktemp("onnx") / "fast.onnx"
    original = checkpoint("planes")
    with pytest.MonkeyPatch.context() as patch:
        # An untrained network has no confident answer.
        patch.setattr(fidelity_module, "AGREEMENT", 0.8)
        fidelity = export_onnx([original], path, 2, 1.5, calibration=NetworkInputs(some_grids(128)))
    return original, path, fidelity


def some_grids(count, seed=7):
    rng = np.random.default_rng(seed)
    density = rng.uniform(0.02, 0.2, (count, 1, 1, 1, 1))
    return (rng.random((count, 1, 32, 32, 32)) < density).astype(np.uint8)


def test_eight_bits_answer_nearly_the_same_from_a_smaller_file(in_eight_bits, tmp_path):
    original, path, fidelity = in_eight_bits
    export_onnx([original], tmp_path / "plain.onnx", 2, 1.5)
    assert path.stat().st_size < 0.6 * (tmp_path / "plain.onnx").stat().st_size
    assert fidelity.difference > 0
    assert fidelity.agreement >= 0.8
    grids = some_grids(16, seed=8).reshape(8, 2, 32, 32, 32)
    fast, plain = (Classifier.load(p) for p in (path, tmp_path / "plain.onnx"))
    assert fast.description == plain.description
    np.testing.assert_allclose(fast.probabilities(grids), plain.probabilities(grids), atol=0.1)


def test_eight_bits_keep_the_circle_closed(in_eight_bits):
    _, path, _ = in_eight_bits
    grid = some_grids(1, seed=9)
    rolls = np.concatenate([np.roll(grid, cells, axis=3) for cells in range(32)])
    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    (logits,) = session.run(["logits"], {"grid": rolls})
    assert np.ptp(logits, axis=0).max() < 1e-4


def test_networks_of_points_go_into_eight_bits_too(tmp_path, monkeypatch):
    monkeypatch.setattr(fidelity_module, "AGREEMENT", 0.0)
    original, path = checkpoint("deeppano"), tmp_path / "fast.onnx"
    export_onnx(
        [original], path, calibration=NetworkInputs(some_inputs(original.input_spec, 8).numpy())
    )
    kinds = {node.op_type for node in onnx.load(path).graph.node}
    assert {"QuantizeLinear", "DequantizeLinear", "Conv"} <= kinds
    shares = Classifier.load(path).probabilities(
        some_inputs(original.input_spec, 2).numpy()[:, None]
    )
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, atol=1e-5)


def test_eight_bits_are_refused_without_convolutions(tmp_path):
    original = checkpoint("pointnet")
    calibration = NetworkInputs(some_inputs(original.input_spec, 8).numpy())
    with pytest.raises(InputError, match="pointnet has no convolutions to quantise; leave out"):
        export_onnx([original], tmp_path / "net.onnx", calibration=calibration)
    assert list(tmp_path.iterdir()) == []


def test_networks_without_convolutions_are_refused_before_the_conversion(exported):
    original, path = exported
    if any(node.op_type == "Conv" for node in onnx.load(path).graph.node):
        require_convolutions([original])
    else:
        with pytest.raises(InputError, match=original.net):
            require_convolutions([original])


def test_eight_bits_that_change_labels_are_not_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(fidelity_module, "AGREEMENT", 1.1)
    with pytest.raises(CircumspectError, match="keep their label"):
        export_onnx(
            [checkpoint("planes")], tmp_path / "net.onnx", calibration=NetworkInputs(some_grids(8))
        )
    with pytest.raises(InputError, match="two grids"):
        export_onnx(
            [checkpoint("planes")], tmp_path / "net.onnx", calibration=NetworkInputs(some_grids(1))
        )
    assert list(tmp_path.iterdir()) == []


def test_every_network_gives_features_in_which_its_logits_are_linear(exported):
    original, path = exported
    classifier = Classifier.load(path)
    inputs = some_inputs(original.input_spec, 4, seed=5).numpy()
    if not isinstance(original.input_spec, PointsSpec):
        inputs = inputs.astype(np.uint8)
    features = classifier.features(inputs[:, None])
    last = [node for node in onnx.load(path).graph.node if node.op_type == "Gemm"][-1]
    weights = {t.name: onnx.numpy_helper.to_array(t) for t in onnx.load(path).graph.initializer}
    logits = features @ weights[last.input[1]].T + weights[last.input[2]]
    np.testing.assert_allclose(logits / 1.5, classifier.scores(inputs[:, None]), atol=1e-4)


def test_an_older_file_gets_features_and_keeps_its_answers(tmp_path):
    export_onnx([checkpoint("planes")], tmp_path / "now.onnx")
    network = onnx.load(tmp_path / "now.onnx")
    del network.graph.output[1:]
    network.graph.node.remove(network.graph.node[-1])
    onnx.save(network, tmp_path / "old.onnx")
    old = Classifier.load(tmp_path / "old.onnx")
    grids = some_grids(3)[:, None]
    with pytest.raises(WeightsError, match="export them again"):
        old.features(grids)
    write_with_features(tmp_path / "old.onnx", tmp_path / "new.onnx")
    new = Classifier.load(tmp_path / "new.onnx")
    np.testing.assert_array_equal(new.scores(grids), old.scores(grids))
    assert new.features(grids).shape == (3, 256)
    assert (tmp_path / "new.onnx").read_bytes() == (tmp_path / "now.onnx").read_bytes()
