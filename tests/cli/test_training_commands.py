"""train, evaluate, export and classify, one after the other, as a user would."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from network_inputs import small_input_spec, trained_looking

from circumspect.classification import Classifier, ExampleTable
from circumspect.classification.shipped import shipped_path
from circumspect.cli.main import main
from circumspect.datasets import open_data_set
from circumspect.datasets.point_pack import write_point_pack
from circumspect.errors import OutputError
from circumspect.furniture import make_furniture
from circumspect.nets import Checkpoint

BRIEF = ("--epochs", 2, "--passes", 1, "--batch-size", 8, "--replicas", 1)


def run(*words):
    return main([str(word) for word in words])


@pytest.fixture(scope="module")
def trained(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    words = ("train", "--data", data, "--out", folder / "run", "--cache", folder / "grids")
    assert run(*words, *BRIEF) == 0
    return folder / "run"


@pytest.fixture(scope="module")
def exported(trained):
    """An ONNX file of it, made once: a conversion takes seconds."""
    assert run("export", trained, trained.parent / "exported.onnx") == 0
    return trained.parent / "exported.onnx"


def test_training_prints_what_it_kept(trained, data, capsys):
    again = ("train", "--data", data, "--out", trained, "--cache", trained.parent / "grids")
    assert run(*again, *BRIEF) == 0
    assert "mean-class accuracy" in capsys.readouterr().out
    assert run(*again, *BRIEF, "--epochs", 3) == 2
    assert "other settings" in capsys.readouterr().err
    assert run("train", "--config", trained / "config.toml") == 0
    assert "mean-class accuracy" in capsys.readouterr().out


def test_few_objects_are_shown_more_often(data, tmp_path, capsys):
    """As with a handful of gathered objects, without extra flags."""
    words = ("train", "--data", data, "--out", tmp_path / "run", "--cache", tmp_path / "grids")
    assert run(*words, "--epochs", 1, "--replicas", 1) == 0
    assert "40 objects are few: an epoch shows all 13 times" in capsys.readouterr().err
    settings = json.loads((tmp_path / "run" / "config.json").read_text())["settings"]
    assert settings["passes"] == 13  # times 40 objects are just over 500


def test_corruption_is_measured_instead(trained, data, tmp_path, capsys):
    words = ("evaluate", "--model", trained, "--data", data, "--split", "test", "--corrupt")
    assert run(*words, "--out", tmp_path, "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((tmp_path / "robustness.json").read_text())
    assert all(len(row) == 5 for row in printed["accuracy"].values())
    assert run(*words, "--out", tmp_path) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].startswith("jitter")
    assert max(map(len, lines[:14])) <= 80


def test_evaluation_writes_metrics_and_figures(trained, data, tmp_path, capsys):
    words = ("evaluate", "--model", trained, "--data", data, "--split", "test")
    assert run(*words, "--yaw", "0,45,90,135", "--out", tmp_path, "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    assert run("evaluate", "--config", tmp_path / "config.toml") == 0
    again = json.loads(capsys.readouterr().out)
    assert {**again, "milliseconds": None} == {**printed, "milliseconds": None}
    printed = again
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    assert printed == metrics
    assert metrics["yaw_deg"] == [0, 45, 90, 135]
    assert metrics["objects"] == 6
    assert not metrics["seen_in_training"]
    assert metrics["classes"] == ["chair", "sofa"]
    assert {"accuracy", "mean_class_accuracy", "worst", "spread", "flip_rate", "confusion",
            "milliseconds"} <= set(metrics)  # fmt: skip
    assert len(list(tmp_path.glob("*.png"))) == 4


@pytest.mark.parametrize(("split", "expected"), [("validation", False), ("train", True)])
def test_figures_on_labelled_surfaces_are_marked(trained, data, tmp_path, capsys, split, expected):
    words = ("evaluate", "--model", trained, "--data", data, "--split", split)
    assert run(*words, "--yaw", "0", "--out", tmp_path) == 0
    assert ("do not quote" in capsys.readouterr().out) == expected
    assert json.loads((tmp_path / "metrics.json").read_text())["seen_in_training"] == expected


def test_the_test_split_is_not_for_training(data, tmp_path, capsys):
    assert run("train", "--data", data / "test.npz", "--out", tmp_path / "run") == 2
    assert "for reports" in capsys.readouterr().err


def test_evaluation_of_weights_for_other_classes(data, tmp_path, capsys):
    assert run("evaluate", "--data", data, "--split", "test", "--out", tmp_path) == 2
    assert "evaluate on a set of the same classes" in capsys.readouterr().err
    assert not (tmp_path / "metrics.json").exists()


def test_an_unwritable_folder_is_refused_first(data, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    words = ("evaluate", "--data", data, "--split", "test", "--out", tmp_path / "file" / "x")
    assert run(*words) == 2
    assert "file" in capsys.readouterr().err


@pytest.mark.parametrize("yaws", ["north", "0,,90", "", "nan,90"])
def test_invalid_yaw_angles_are_refused(data, tmp_path, capsys, yaws):
    words = ("evaluate", "--data", data, "--out", tmp_path, "--yaw", yaws)
    assert run(*words) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_exported_weights_name_files(trained, tmp_path, capsys):
    assert run("export", trained, tmp_path / "own.onnx", "--azimuth-views", 2) == 0
    np.save(tmp_path / "piece.npy", make_furniture("sofa", 7).sampled(3000, 0).points_xyz)
    words = ("classify", tmp_path / "piece.npy", "--model", tmp_path / "own.onnx", "--json")
    capsys.readouterr()
    assert run(*words) == 0
    record = json.loads(capsys.readouterr().out)
    assert set(record["probabilities"]) == {"chair", "sofa"}


def test_a_committee_in_eight_bits_is_evaluated_like_any_weights(
    trained, data, tmp_path, capsys, monkeypatch
):
    # After two epochs on forty pieces the network has no confident answer.
    monkeypatch.setattr("circumspect.export.onnx_export.AGREEMENT", 0.5)
    words = ("export", trained, tmp_path / "fast.onnx", "--committee", trained, "--int8", data)
    assert run(*words) == 0
    assert "same label for" in capsys.readouterr().out
    words = ("evaluate", "--model", tmp_path / "fast.onnx", "--data", data, "--split", "train")
    assert run(*words, "--yaw", "0", "--out", tmp_path / "out", "--json") == 0
    assert json.loads(capsys.readouterr().out)["seen_in_training"]


def test_eight_bits_need_a_data_set(trained, tmp_path, capsys):
    assert run("export", trained, tmp_path / "own.onnx", "--int8", tmp_path / "nowhere") == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_export_of_nothing(tmp_path, capsys):
    assert run("export", tmp_path, tmp_path / "own.onnx") == 2
    assert "train first" in capsys.readouterr().err


def test_eight_bits_of_a_network_without_convolutions(tmp_path, capsys):
    """Refused before the data are opened, which may take minutes."""
    net = trained_looking("pointnet")
    weights = tmp_path / "net.safetensors"
    Checkpoint("pointnet", ("a", "b", "c"), small_input_spec("pointnet"), net.state_dict()).save(
        weights
    )
    words = ("export", weights, tmp_path / "own.onnx", "--int8", tmp_path / "none")
    assert run(*words) == 2
    assert "pointnet has no convolutions to quantise; leave out --int8" in capsys.readouterr().err


def test_evaluation_of_a_folder_without_weights(data, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert run("evaluate", "--model", tmp_path / "empty", "--data", data) == 2
    assert "train first" in capsys.readouterr().err


def test_data_that_is_not_there(tmp_path, capsys):
    assert run("train", "--data", tmp_path / "none", "--out", tmp_path / "run") == 2
    assert "none" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_objects_that_were_trained_on_are_known_by_name(trained, data, tmp_path, capsys):
    """Another copy of the set, and a part of it, hold the same objects."""
    train = open_data_set(data, "train")
    rng = np.random.default_rng(0)
    moved = train.points_xyz + rng.normal(0, 1e-3, train.points_xyz.shape).astype(np.float32)
    known = Checkpoint.load(trained / "best.safetensors").training["objects"]
    assert 0 < len(known) < len(train)
    write_point_pack(tmp_path / "train.npz", replace(train, points_xyz=moved))
    for split, expected in (("train", True), ("validation", False)):
        words = ("evaluate", "--model", trained, "--data", tmp_path, "--split", split)
        assert run(*words, "--yaw", "0", "--out", tmp_path / split, "--json") == 0
        metrics = json.loads(capsys.readouterr().out)
        assert metrics["seen_in_training"] == expected
        assert metrics["objects"] == (len(train) if expected else len(train) - len(known))


def test_an_older_file_gets_the_names_of_its_training_objects(trained, data, tmp_path, capsys):
    old = Checkpoint.load(trained / "best.safetensors")
    names = old.training["objects"]
    nameless = {key: value for key, value in old.training.items() if key != "objects"}
    replace(old, training=nameless).save(tmp_path / "old.safetensors")
    assert run("export", tmp_path / "old.safetensors", tmp_path / "own.onnx") == 0
    assert "objects" not in Classifier.load(tmp_path / "own.onnx").training
    words = ("export", tmp_path / "own.onnx", tmp_path / "own.onnx", "--examples", data)
    assert run(*words) == 0
    assert "names the objects" in capsys.readouterr().out
    assert Classifier.load(tmp_path / "own.onnx").training["objects"] == names
    assert run(*words) == 0
    assert "names the objects" not in capsys.readouterr().out


def test_examples_are_exactly_the_training_objects(trained, data, tmp_path, capsys):
    known = Checkpoint.load(trained / "best.safetensors").training["objects"]
    assert run("export", trained, tmp_path / "own.onnx", "--examples", data) == 0
    table = ExampleTable.load(tmp_path / "own.examples.npz")
    assert sorted(table.names.tolist()) == sorted(known)
    shutil.copy(data / "test.npz", tmp_path / "others.npz")
    capsys.readouterr()
    words = ("export", trained, tmp_path / "again.onnx", "--examples", tmp_path / "others.npz")
    assert run(*words) == 2
    assert f"{words[-1]}: the weights were trained on none" in capsys.readouterr().err
    assert not (tmp_path / "again.examples.npz").exists()
    assert not (tmp_path / "again.onnx").exists()


@pytest.mark.parametrize(
    "step",
    [
        "circumspect.export.nearest.atomic_path",
        "circumspect.classification.example_table.atomic_open",
    ],
)
def test_a_disk_that_fails_leaves_both_files_as_they_were(
    trained, exported, data, tmp_path, capsys, monkeypatch, step
):
    def full(path, *_):
        raise OutputError(f"{path}: can not be written (no space left on device)")

    old, new, flags = tmp_path / "old.onnx", tmp_path / "new.onnx", ("--examples", data)
    assert run("export", exported, old, *flags) == 0
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert set(before) == {"old.onnx", "old.examples.npz"}
    capsys.readouterr()
    monkeypatch.setattr(step, full)
    for words in ((trained, new, *flags), (old, old, *flags, "--unknown-beyond", 0.5)):
        assert run("export", *words) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert f"{words[1].with_suffix('')}." in err
        assert "can not be written" in err
        assert before == {file.name: file.read_bytes() for file in tmp_path.iterdir()}


def test_a_checkpoint_is_not_written_over_by_its_export(trained, capsys):
    best = trained / "best.safetensors"
    before = best.read_bytes()
    assert run("export", trained, best) == 2
    assert "give a name that ends in .onnx" in capsys.readouterr().err
    assert best.read_bytes() == before


def test_an_object_far_from_all_examples_is_unknown(trained, exported, data, tmp_path, capsys):
    own, cloud = tmp_path / "own.onnx", open_data_set(data, "test").cloud(0)
    shutil.copy(exported, own)
    assert Classifier.load(own).classify(cloud).in_distribution
    for beyond in (0.0, 2.0):
        words = ("export", own, own, "--examples", data, "--unknown-beyond", beyond)
        assert run(*words) == 0
        answer = Classifier.load(own).classify(cloud)
        # Two epochs may leave features that hardly differ: then nothing is far from anything.
        assert 0 <= answer.distance < 2
        assert answer.in_distribution is (answer.distance <= beyond)
    capsys.readouterr()
    words = ("evaluate", "--model", own, "--data", data, "--yaw", "0", "--json")
    assert run(*words, "--out", tmp_path / "out") == 0
    assert 0 <= json.loads(capsys.readouterr().out)["unknown_beyond"] <= 2
    for flags, says in (
        (("--unknown-beyond", 0.1), "give both"),
        (("--examples", data, "--unknown-beyond", 3), "lie in 0 … 2, not 3"),
    ):
        assert run("export", trained, tmp_path / "no.onnx", *flags) == 2
        assert says in capsys.readouterr().err
    assert not (tmp_path / "no.onnx").exists()


def test_modelnet10_names_its_training_objects():
    names = Classifier.load("modelnet10").training["objects"]
    assert len(set(names)) == 3991
    assert "chair_0889" in names
    assert "chair_0890" not in names


def test_a_temperature_counts_from_none(exported, data, tmp_path, capsys):
    """The temperature that `evaluate` prints is the one to export the weights with."""
    found = []
    for temperature in (1, 2):
        own = tmp_path / "own.onnx"
        assert run("export", exported, own, "--temperature", temperature) == 0
        words = ("evaluate", "--model", own, "--data", data, "--yaw", "0,30", "--json")
        capsys.readouterr()
        assert run(*words, "--out", tmp_path / "out") == 0
        found.append(json.loads(capsys.readouterr().out)["fitted_temperature"])
    assert found[0] == pytest.approx(found[1], rel=1e-3)


def test_a_run_goes_on_after_it_was_evaluated_in_its_own_folder(trained, data, tmp_path):
    words = ("--data", data, "--cache", trained.parent / "grids", *BRIEF)
    shutil.copytree(trained, tmp_path / "run")
    evaluate = ("evaluate", "--model", tmp_path / "run", "--data", data, "--split", "test")
    assert run(*evaluate, "--yaw", "0", "--out", tmp_path / "run") == 0
    assert run("train", *words, "--out", tmp_path / "run") == 0


@pytest.mark.parametrize("flag", ["--int8", "--committee"])
def test_an_exported_file_keeps_its_weights(tmp_path, capsys, flag):
    missing = (flag, tmp_path / "none", "--examples", tmp_path / "none")
    assert run("export", shipped_path("modelnet10"), tmp_path / "own.onnx", *missing) == 2
    assert f"{flag} goes with checkpoints" in capsys.readouterr().err
    assert not (tmp_path / "own.onnx").exists()


def test_an_exported_file_takes_other_views_and_temperature(tmp_path, capsys):
    shipped, own = Classifier.load("modelnet10"), tmp_path / "own.onnx"
    grids = np.zeros((1, 1, *shipped.input_spec.input_shape), np.uint8)
    grids[..., 3:9, ::5, 2:] = 1
    assert (
        run("export", shipped_path("modelnet10"), own, "--azimuth-views", 2, "--temperature", 3)
        == 0
    )
    input_spec = shipped.input_spec.with_views(2)
    assert Classifier.load(own).input_spec == input_spec
    assert run("export", own, own, "--dithered") == 0
    printed = capsys.readouterr().out
    assert "2 inputs an object, temperature 3; --examples DATA" in printed
    assert "2 dithered inputs an object, temperature 3; --examples DATA" in printed
    other = Classifier.load(own)
    assert other.input_spec == input_spec.with_views(2, dithered=True)
    assert {**other.description, "grid": 0, "temperature": 0} == {
        **shipped.description, "grid": 0, "temperature": 0,
    }  # fmt: skip
    np.testing.assert_allclose(
        3.0 * other.scores(grids), shipped.temperature * shipped.scores(grids), rtol=1e-12
    )


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (("--azimuth-views", 0), "from 1 to 64"),
        (("--azimuth-views", 1, "--dithered"), "give --azimuth-views 8"),
        (("--temperature", -3), "positive"),
    ],
)
def test_invalid_export_settings_are_refused(tmp_path, capsys, flags, says):
    assert run("export", shipped_path("modelnet10"), tmp_path / "own.onnx", *flags) == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "own.onnx").exists()


@pytest.mark.parametrize("flags", [("--corrupt", "--yaw", "0"), ("--corrupt", "--yaw-count", 8),
                                   ("--yaw", "0", "--yaw-count", 8)])  # fmt: skip
def test_angles_that_would_be_ignored_are_refused(data, tmp_path, capsys, flags):
    assert run("evaluate", "--data", data, "--out", tmp_path / "out", *flags) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("seed", [-1, 2**32])
def test_invalid_seeds_are_refused(data, tmp_path, capsys, seed):
    assert run("train", "--data", data, "--out", tmp_path / "run", "--seed", seed) == 2
    assert "seed" in capsys.readouterr().err


def test_a_finished_network_is_not_trained_over(trained, data, tmp_path, capsys):
    shutil.copytree(trained, tmp_path / "run")
    (tmp_path / "run" / "state.safetensors").unlink()
    before = (tmp_path / "run" / "best.safetensors").read_bytes()
    words = ("train", "--data", data, "--out", tmp_path / "run", *BRIEF)
    assert run(*words) == 2
    assert (
        "holds a run's network without a state to resume from; choose another --out"
        in capsys.readouterr().err
    )
    assert (tmp_path / "run" / "best.safetensors").read_bytes() == before


def test_views_of_a_rectangular_grid_would_all_be_the_same(data, tmp_path, capsys):
    words = ("train", "--net", "voxnet", "--cells", 16, 16, 16, "--data", data, *BRIEF)
    where = ("--out", tmp_path / "run", "--cache", tmp_path / "grids")
    assert run(*words, *where, "--epochs", 1) == 0
    capsys.readouterr()
    # Refused before the sets are opened, which takes a while.
    wrong = ("--azimuth-views", 4, "--examples", tmp_path / "none", "--int8", tmp_path / "none")
    assert run("export", tmp_path / "run", tmp_path / "own.onnx", *wrong) == 2
    assert "leave out --azimuth-views" in capsys.readouterr().err
    assert not (tmp_path / "own.onnx").exists()
