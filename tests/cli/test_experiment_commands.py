"""What `reproduce` refuses, before hours of training."""

import shutil
from dataclasses import replace

import pytest

from circumspect.cli.main import main
from circumspect.datasets import open_data_set
from circumspect.datasets.point_pack import write_point_pack


def run(*words):
    return main([str(word) for word in words])


@pytest.mark.parametrize(
    ("flag", "value"),
    [
        *(("epochs", value) for value in ("many", "0", "moon2018=", "=3", "moon=3", "٣")),
        *(("precision", value) for value in ("fp16", "moon2018=", "=bf16", "moon=bf16", "BF16")),
    ],
)
def test_invalid_epochs_and_precisions_are_refused(data, tmp_path, capsys, flag, value):
    words = ("reproduce", "rivals", "--data", data, "--out", tmp_path / "out", f"--{flag}", value)
    assert run(*words) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("what", ["table2", "rivals", "robustness", "unknown"])
def test_experiments_on_other_classes_are_refused_before_the_training(data, tmp_path, capsys, what):
    assert run("reproduce", what, "--data", data, "--out", tmp_path / "out") == 2
    stderr = capsys.readouterr().err
    assert "the training split lacks bathtub and bed and desk" in stderr
    assert stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("rivals", "--nets", "voxne"), "did you mean voxnet?"),
        (("rivals", "--nets", "voxne-random-yaw"), "did you mean voxnet?"),
        (("rivals", "--only", "voxne"), "--only voxne: this comparison has circumspect, moon2018"),
        (("robustness", "--only", "pointmlp"), "--only pointmlp: this comparison has circumspect"),
        (("rivals", "--epochs", "headed-planes-random-yaw=3"), "learns which way objects face"),
        (("table2", "--nets", "voxnet"), "--nets goes with rivals and robustness"),
        (("unknown", "--only", "planes"), "--only goes with rivals and robustness"),
    ],
)
def test_unknown_networks_of_an_experiment_are_refused(data, tmp_path, capsys, words, why):
    assert run("reproduce", *words, "--data", data, "--out", tmp_path / "out") == 2
    assert why in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_one_pack_as_both_splits_is_refused(data, tmp_path, capsys):
    shutil.copy(data / "train.npz", tmp_path / "all.npz")
    words = ("reproduce", "unknown", "--data", tmp_path / "all.npz", "--out", tmp_path / "out")
    assert run(*words) == 2
    assert "40 objects are in both splits, as train_chair_0000 is" in capsys.readouterr().err


def test_splits_of_other_classes_are_refused_before_training(data, tmp_path, capsys):
    train = open_data_set(data, "train")
    write_point_pack(tmp_path / "train.npz", train)
    chairs = open_data_set(data, "test")
    write_point_pack(tmp_path / "test.npz", replace(chairs, classes=("chair", "throne")))
    words = ("reproduce", "rivals", "--data", tmp_path, "--out", tmp_path / "out")
    assert run(*words) == 2
    assert "the test split chair, throne" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("flag", ["--epochs=pointnet=3", "--precision=pointnet=bf16"])
def test_settings_of_a_network_outside_the_experiment_are_refused(data, tmp_path, capsys, flag):
    words = ("reproduce", "table2", "--data", data, "--out", tmp_path / "out")
    assert run(*words, flag) == 2
    assert "trains moon2018, moon2018-max, planes" in capsys.readouterr().err
