"""train, evaluate, export and classify, one after the other, as a user would."""

import json

import numpy as np
import pytest

from circumspect.cli.main import main
from circumspect.datasets import ObjectSet
from circumspect.datasets.point_pack import write_point_pack
from circumspect.furniture import make_furniture

BRIEF = ("--epochs", 2, "--passes", 1, "--batch-size", 8, "--replicas", 1)


def run(*words):
    return main([str(word) for word in words])


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Chairs and sofas as point packs."""
    folder = tmp_path_factory.mktemp("data")
    classes = ("chair", "sofa")
    for split, count in (("train", 40), ("test", 6)):
        labels = np.arange(count) % 2
        pieces = [make_furniture(classes[k], 50 + i) for i, k in enumerate(labels)]
        points = np.stack([piece.sampled(400, 0).points_xyz for piece in pieces])
        names = np.array([f"{split}_{classes[k]}_{i:04d}" for i, k in enumerate(labels)])
        objects = ObjectSet(points.astype(np.float32), labels.astype(np.int64), names, classes)
        write_point_pack(folder / f"{split}.npz", objects)
    return folder


@pytest.fixture(scope="module")
def trained(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    words = ("train", "--data", data, "--out", folder / "run", "--cache", folder / "grids")
    assert run(*words, *BRIEF) == 0
    return folder / "run"


def test_training_says_what_it_kept(trained, data, capsys):
    again = ("train", "--data", data, "--out", trained, "--cache", trained.parent / "grids")
    assert run(*again, *BRIEF) == 0
    assert "mean-class accuracy" in capsys.readouterr().out
    assert run(*again, *BRIEF, "--epochs", 3) == 2
    assert "other settings" in capsys.readouterr().err


def test_few_objects_are_shown_more_often(data, tmp_path, capsys):
    """As a user would who gathered a handful: without flags for it."""
    words = ("train", "--data", data, "--out", tmp_path / "run", "--cache", tmp_path / "grids")
    assert run(*words, "--epochs", 1, "--replicas", 1) == 0
    assert "40 objects are few: an epoch shows all 13 times" in capsys.readouterr().err
    settings = json.loads((tmp_path / "run" / "config.json").read_text())["settings"]
    assert settings["passes"] == 13  # times 40 objects are just over 500


def test_corruption_is_measured_instead(trained, data, tmp_path, capsys):
    words = ("evaluate", "--weights", trained, "--data", data, "--split", "test", "--corrupt")
    assert run(*words, "--out", tmp_path, "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((tmp_path / "robustness.json").read_text())
    assert all(len(row) == 5 for row in printed["accuracy"].values())
    assert run(*words, "--out", tmp_path) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].startswith("jitter")
    assert max(map(len, lines[:14])) <= 80


def test_evaluation_writes_metrics_and_figures(trained, data, tmp_path, capsys):
    words = ("evaluate", "--weights", trained, "--data", data, "--split", "test")
    assert run(*words, "--yaw", "0,45,90,135", "--out", tmp_path, "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    assert printed == metrics
    assert metrics["yaw_deg"] == [0, 45, 90, 135]
    assert metrics["objects"] == 6
    assert not metrics["seen_in_training"]
    assert metrics["classes"] == ["chair", "sofa"]
    assert {"accuracy", "mean_class_accuracy", "worst", "spread", "flip_rate", "confusion",
            "milliseconds"} <= set(metrics)  # fmt: skip
    assert len(list(tmp_path.glob("*.png"))) == 4


@pytest.mark.parametrize(("split", "seen"), [("validation", False), ("train", True)])
def test_figures_on_training_objects_are_marked(trained, data, tmp_path, capsys, split, seen):
    words = ("evaluate", "--weights", trained, "--data", data, "--split", split)
    assert run(*words, "--yaw", "0", "--out", tmp_path) == 0
    assert ("do not quote" in capsys.readouterr().out) == seen
    assert json.loads((tmp_path / "metrics.json").read_text())["seen_in_training"] == seen


def test_the_test_split_is_not_for_training(data, tmp_path, capsys):
    assert run("train", "--data", data / "test.npz", "--out", tmp_path / "run") == 2
    assert "for reports" in capsys.readouterr().err


def test_evaluation_of_weights_for_other_classes(data, tmp_path, capsys):
    assert run("evaluate", "--data", data, "--split", "test", "--out", tmp_path) == 2
    assert "evaluate on a set of the same classes" in capsys.readouterr().err
    assert not (tmp_path / "metrics.json").exists()


def test_a_folder_that_can_not_be_written_is_found_out_first(data, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    words = ("evaluate", "--data", data, "--split", "test", "--out", tmp_path / "file" / "x")
    assert run(*words) == 2
    assert "file" in capsys.readouterr().err


@pytest.mark.parametrize("yaws", ["north", "0,,90", "", "nan,90"])
def test_yaws_that_are_no_numbers(data, tmp_path, capsys, yaws):
    words = ("evaluate", "--data", data, "--out", tmp_path, "--yaw", yaws)
    assert run(*words) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_exported_weights_name_files(trained, tmp_path, capsys):
    assert run("export", trained, tmp_path / "own.onnx", "--azimuth-views", 2) == 0
    np.save(tmp_path / "piece.npy", make_furniture("sofa", 7).sampled(3000, 0).points_xyz)
    words = ("classify", tmp_path / "piece.npy", "--weights", tmp_path / "own.onnx", "--json")
    capsys.readouterr()
    assert run(*words) == 0
    record = json.loads(capsys.readouterr().out)
    assert set(record["probabilities"]) == {"chair", "sofa"}


def test_a_committee_in_eight_bits_is_evaluated_like_any_weights(
    trained, data, tmp_path, capsys, monkeypatch
):
    # Two epochs on forty pieces leave a net that is sure of nothing.
    monkeypatch.setattr("circumspect.export.onnx_export.AGREEMENT", 0.5)
    words = ("export", trained, tmp_path / "fast.onnx", "--committee", trained, "--int8", data)
    assert run(*words) == 0
    assert "same label for" in capsys.readouterr().out
    words = ("evaluate", "--weights", tmp_path / "fast.onnx", "--data", data, "--split", "train")
    assert run(*words, "--yaw", "0", "--out", tmp_path / "out", "--json") == 0
    assert json.loads(capsys.readouterr().out)["seen_in_training"]


def test_eight_bits_need_a_data_set(trained, tmp_path, capsys):
    assert run("export", trained, tmp_path / "own.onnx", "--int8", tmp_path / "nowhere") == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_export_of_nothing(tmp_path, capsys):
    assert run("export", tmp_path, tmp_path / "own.onnx") == 2
    assert "train first" in capsys.readouterr().err


def test_evaluation_of_a_folder_without_weights(data, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert run("evaluate", "--weights", tmp_path / "empty", "--data", data) == 2
    assert "train first" in capsys.readouterr().err


def test_data_that_is_not_there(tmp_path, capsys):
    assert run("train", "--data", tmp_path / "none", "--out", tmp_path / "run") == 2
    assert "none" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("epochs", ["many", "0", "moon2018=", "=3", "moon=3", "٣"])
def test_experiments_of_no_number_of_epochs(data, tmp_path, capsys, epochs):
    words = ("reproduce", "rivals", "--data", data, "--out", tmp_path / "out", "--epochs", epochs)
    assert run(*words) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("what", ["rivals", "unknown"])
def test_experiments_on_other_classes_are_refused_before_the_training(data, tmp_path, capsys, what):
    assert run("reproduce", what, "--data", data, "--out", tmp_path / "out") == 2
    assert "a set of the same classes" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("rivals", "--nets", "voxne"), "did you mean voxnet?"),
        (("table2", "--nets", "voxnet"), "--nets goes with rivals and robustness"),
    ],
)
def test_experiments_with_networks_that_are_none(data, tmp_path, capsys, words, why):
    assert run("reproduce", *words, "--data", data, "--out", tmp_path / "out") == 2
    assert why in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
