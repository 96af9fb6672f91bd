"""Training on simulated scans, from surfaces to a classifier that knows size and visibility."""

from dataclasses import replace

import numpy as np
import pytest
from quick_run import Silent

from circumspect.classification import Classifier, GridSpec
from circumspect.classification.context import SCALE_KNOWN, VISIBILITY_KNOWN
from circumspect.datasets import GridCache, ObjectSet
from circumspect.datasets.farthest_points import evenly_sampled
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.datasets.scan_sources import procedural
from circumspect.errors import InputError
from circumspect.export import export_onnx, onnx_export
from circumspect.export.conversion import NetworkInputs
from circumspect.furniture import make_furniture
from circumspect.grid.grid import FREE
from circumspect.nets import Checkpoint
from circumspect.training import TrainingSettings
from circumspect.training.scan_data import ScanSamples
from circumspect.training.train import train

CLASSES = ("chair", "dresser")
SETTINGS = TrainingSettings(
    scans=True, epochs=2, batch_size=8, replicas=2, catalogue_replicas=2, furniture=0.2,
    furniture_each=1, furniture_others=1, catalogue=0.0, draws=24, seed=1, validation=False,
)  # fmt: skip


def few_objects():
    """Two pieces of each class, as points."""
    made = [(name, seed) for name in CLASSES for seed in range(2)]
    points = np.stack([evenly_sampled(make_furniture(name, seed)) for name, seed in made])
    labels = np.array([CLASSES.index(name) for name, _ in made])
    names = np.array([f"{name}_{seed:04d}" for name, seed in made])
    return ObjectSet(points, labels, names, CLASSES)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans")
    settings = replace(SETTINGS, furniture=0.0)
    checkpoint = train(
        few_objects(), settings, folder / "run", Silent(), GridCache(folder / "cache"),
        catalogues=[only_of_classes(procedural(1, 1, held_back=True))],
    )  # fmt: skip
    return folder, checkpoint


def only_of_classes(objects):
    return objects.subset(np.isin(objects.labels, [*CLASSES, OTHER]))


def test_a_checkpoint_has_a_class_of_other_things_and_states_its_input(trained):
    folder, checkpoint = trained
    assert checkpoint.classes == (*CLASSES, OTHER)
    assert checkpoint.input_spec.visibility
    assert checkpoint.input_spec.metric
    again = Checkpoint.load(folder / "run" / "best.safetensors")
    assert again.input_spec == checkpoint.input_spec
    assert {"chair_0000", "dresser_0001"} <= set(again.training["objects"])


def test_a_finished_run_is_not_repeated(trained):
    folder, _checkpoint = trained
    calls = []

    class Watching(Silent):
        def finished_epoch(self, row):
            calls.append(row)

    train(
        few_objects(), replace(SETTINGS, furniture=0.0), folder / "run", Watching(),
        GridCache(folder / "cache"),
        catalogues=[only_of_classes(procedural(1, 1, held_back=True))],
    )  # fmt: skip
    assert calls == []


def test_other_catalogues_are_another_run(trained):
    folder, _ = trained
    with pytest.raises(InputError, match="other catalogues"):
        train(
            few_objects(), replace(SETTINGS, furniture=0.0), folder / "run", Silent(),
            GridCache(folder / "cache"),
        )  # fmt: skip


@pytest.fixture(scope="module")
def exported(trained):
    folder, checkpoint = trained
    export_onnx([checkpoint], folder / "net.onnx", 2, dithered=True)
    return folder / "net.onnx"


@pytest.mark.parametrize("eight_bits", [False, True])
def test_the_exported_classifier_answers_with_and_without_size(
    trained, exported, tmp_path, eight_bits
):
    _, checkpoint = trained
    rng = np.random.default_rng(0)
    calibration = NetworkInputs(
        (rng.random((16, 1, 32, 32, 32)) < 0.05).astype(np.uint8) * np.uint8(2),
        rng.normal(size=(16, 6)).astype(np.float32),
    )
    path = exported
    if eight_bits:
        path = tmp_path / "fast.onnx"
        with pytest.MonkeyPatch.context() as patch:
            # After two epochs quantisation may change answers.
            patch.setattr(onnx_export, "AGREEMENT", 0.0)
            export_onnx([checkpoint], path, 2, 1.0, calibration, True)
    classifier = Classifier.load(path, 1)
    assert classifier.classes == CLASSES
    assert classifier.other == OTHER
    cloud = make_furniture("chair", 7).sampled(3000)
    known, unknown = classifier.classify(cloud, metric=True), classifier.classify(cloud)
    assert set(known.probabilities) == set(CLASSES)
    assert known.probabilities != unknown.probabilities
    assert sum(known.probabilities.values()) == pytest.approx(1.0)


def test_a_metric_object_of_implausible_size_is_refused(exported):
    classifier = Classifier.load(exported, 1)
    points = make_furniture("chair", 7).sampled(3000).points_xyz
    for factor, shown in ((1e-3, "mm"), (100.0, "m")):
        with pytest.raises(InputError, match=f"{shown} long.*check the unit"):
            classifier.classify(points * factor, metric=True)
    classifier.classify(points * 100.0)


def test_traced_rays_change_the_answer(exported):
    classifier = Classifier.load(exported, 1)
    cloud = make_furniture("chair", 7).sampled(3000)
    bounds = classifier.input_spec.bounds(cloud)
    hits = bounds.hits(cloud)
    rays = hits.merged(bounds.trace([3.0, 0.0, 1.5], cloud.points_xyz, np.zeros(3000, bool)))
    assert (rays.states == FREE).any()
    first = classifier.classify_grid(hits, metric=True)
    assert first.probabilities != classifier.classify_grid(rays, metric=True).probabilities


class Fixed:
    """Scans of one cell each."""

    input_spec = GridSpec(shape=(2, 4, 2), visibility=True, metric=True)
    scans = 2

    def __init__(self, count):
        self.context = np.ones((count, self.scans, 6), np.float32)

    def inputs(self, objects, scans):
        states = np.ones((len(objects), 1, *self.input_spec.shape), np.uint8)
        states[:, 0, 0, 0] = 2
        return states


def samples(**changes):
    objects = procedural(1, 1)
    settings = replace(SETTINGS, **changes)
    return ScanSamples(
        [(Fixed(len(objects)), objects, 1.0)], (*sorted(set(objects.labels) - {OTHER}), OTHER),
        settings,
    )  # fmt: skip


def test_other_things_are_drawn_as_often_as_the_settings_say():
    drawn = samples(other_weight=2.0)
    other = drawn.targets[:, -1] == 1
    assert drawn.chances.sum() == pytest.approx(1.0)
    assert drawn.chances[other].sum() == pytest.approx(2 / 12)


@pytest.mark.parametrize("hidden", [0.0, 1.0])
def test_hidden_context_leaves_no_trace(hidden):
    drawn = samples(hide_visibility=hidden, hide_scale=hidden)
    states, contexts = drawn.inputs(np.arange(5), np.arange(5), np.random.default_rng(0))
    assert states.shape == (5, 1, 2, 4, 2)
    assert (states == FREE).any() == (not hidden)
    assert (contexts[:, VISIBILITY_KNOWN] == 1 - hidden).all()
    assert (contexts[:, SCALE_KNOWN:] == 1 - hidden).all()


def test_classes_that_the_set_lacks_are_refused(tmp_path):
    with pytest.raises(InputError, match="classes that the set lacks: bathtub"):
        train(
            few_objects(), SETTINGS, tmp_path / "run", Silent(), GridCache(tmp_path / "cache"),
            catalogues=[procedural(1, 0)],
        )  # fmt: skip


@pytest.mark.parametrize("net", ["pointnet", "voxnet"])
def test_networks_without_a_context_are_trained_on_the_same_scans(tmp_path, net):
    settings = replace(SETTINGS, net=net, epochs=1, draws=8, furniture=0.0)
    checkpoint = train(
        few_objects(), settings, tmp_path / "run", Silent(), GridCache(tmp_path / "cache"),
        catalogues=[only_of_classes(procedural(1, 1, held_back=True))],
    )  # fmt: skip
    assert checkpoint.classes == (*CLASSES, OTHER)
    assert not checkpoint.input_spec.takes_context
