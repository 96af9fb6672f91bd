"""`circumspect calibrate`, from a trained network to a classifier that knows when to be confident."""

from dataclasses import replace

import numpy as np
import pytest

from circumspect.classification import Classifier
from circumspect.classification.shipped import shipped_path
from circumspect.cli.commands import calibrate
from circumspect.cli.main import main
from circumspect.datasets import GridCache, ObjectSet
from circumspect.datasets.farthest_points import evenly_sampled
from circumspect.datasets.point_pack import write_point_pack
from circumspect.export import export_onnx
from circumspect.furniture import make_furniture
from circumspect.training import TrainingSettings
from circumspect.training.train import train

pytestmark = pytest.mark.xdist_group("calibrate")  # One network for all tests.
CLASSES = ("chair", "dresser")
SETTINGS = TrainingSettings(
    scans=True, epochs=1, batch_size=8, replicas=1, catalogue_replicas=1, furniture=0.3,
    furniture_each=1, furniture_others=1, catalogue=0.0, draws=16, seed=1,
)  # fmt: skip


class Silent:
    def preparing(self, done, total):
        pass

    def stepped(self, epoch, step, steps, loss):
        pass

    def finished_epoch(self, row):
        pass


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """A network of two classes that was trained with validation, and its set."""
    folder = tmp_path_factory.mktemp("calibrate")
    made = [(name, seed) for name in CLASSES for seed in range(8)]
    points = np.stack([evenly_sampled(make_furniture(name, seed)) for name, seed in made])
    labels = np.array([CLASSES.index(name) for name, _ in made])
    names = np.array([f"{name}_{seed:04d}" for name, seed in made])
    objects = ObjectSet(points, labels, names, CLASSES)
    write_point_pack(folder / "set" / "train.npz", objects)
    from circumspect.datasets import open_data_set

    objects = open_data_set(folder / "set", "train")
    with pytest.MonkeyPatch.context() as patch:
        from circumspect.training import scan_data

        # Furniture has ten categories, more than the classes of this set.
        patch.setattr(scan_data, "procedural", few_others)
        checkpoint = train(objects, SETTINGS, folder / "run", Silent(), GridCache(folder / "cache"))
    export_onnx([checkpoint], folder / "net.onnx", 2, 1.0, None, True)
    return folder


def few_others(each, others, held_back=False):
    from circumspect.datasets.scan_sources import procedural

    found = procedural(each, others, held_back)
    return found.subset(np.isin(found.labels, [*CLASSES, "other"]))


def calibrated(folder, out, *words):
    return main(
        [
            "calibrate", str(folder / "net.onnx"), str(out), "--data", str(folder / "set"),
            "--scans", "2", *words,
        ]
    )  # fmt: skip


def test_a_calibrated_file_states_its_bounds(exported, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(calibrate, "PROCEDURAL", 1)
    assert calibrated(exported, tmp_path / "out.onnx") == 0
    shown = capsys.readouterr().out
    assert "confident from" in shown
    assert "confident with unknown coverage" in shown
    before, after = Classifier.load(exported / "net.onnx"), Classifier.load(tmp_path / "out.onnx")
    assert before.open_set is None
    assert after.open_set is not None
    assert after.description["confidence"] == after.rule.to_dict()
    cloud = make_furniture("chair", 77).sampled(3000)
    prediction = after.classify(cloud, metric=True)
    assert 0 <= prediction.in_distribution_probability <= 1
    # The same network: the temperature alone changes the logits.
    first, second = (
        np.log(list(model.classify(cloud, metric=True).probabilities.values())) * model.temperature
        for model in (before, after)
    )
    np.testing.assert_allclose(np.diff(first), np.diff(second), rtol=1e-3, atol=1e-3)


def test_real_objects_join_the_calibration(exported, tmp_path, monkeypatch):
    monkeypatch.setattr(calibrate, "PROCEDURAL", 1)
    clouds = [make_furniture(name, 99).sampled(400).points_xyz for name in (*CLASSES, "toilet")]
    np.savez(
        tmp_path / "crops.npz",
        points=np.concatenate(clouds).astype(np.float32),
        offsets=np.cumsum([0, *map(len, clouds)]),
        label=np.array([*CLASSES, "lamp"]),
        scene=np.array(["a", "a", "b"]),
    )
    out = tmp_path / "out.onnx"
    assert calibrated(exported, out, "--real", str(tmp_path / "crops.npz")) == 0
    assert Classifier.load(out).open_set is not None


def test_real_objects_of_ambiguous_labels_alone_are_refused(
    exported, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(calibrate, "PROCEDURAL", 1)
    cloud = make_furniture("chair", 99).sampled(400).points_xyz
    np.savez(
        tmp_path / "crops.npz",
        points=cloud.astype(np.float32),
        offsets=np.array([0, len(cloud)]),
        label=np.array(["armchair"]),
        scene=np.array(["a"]),
    )
    out = tmp_path / "out.onnx"
    assert calibrated(exported, out, "--real", str(tmp_path / "crops.npz")) == 2
    assert "ambiguous" in capsys.readouterr().err
    assert not out.exists()


def test_a_network_without_scans_is_refused(exported, tmp_path, capsys):
    words = ["calibrate", str(shipped_path("modelnet10")), str(tmp_path / "out.onnx")]
    assert main([*words, "--data", str(exported / "set")]) == 2
    assert "was not trained with --scans" in capsys.readouterr().err
    assert not (tmp_path / "out.onnx").exists()


@pytest.mark.parametrize("share", ["0", "1", "-0.1", "nan"])
def test_an_invalid_error_rate_is_refused(exported, tmp_path, capsys, share):
    assert calibrated(exported, tmp_path / "out.onnx", f"--max-error-rate={share}") == 2
    assert "--max-error-rate" in capsys.readouterr().err


def test_settings_of_other_scans_are_read_back():
    settings = replace(SETTINGS.scan, single=0.7)
    from dataclasses import asdict

    assert type(settings).from_dict(asdict(settings)) == settings
