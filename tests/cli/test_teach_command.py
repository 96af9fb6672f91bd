"""Teaching the shipped robot classifier shapes that it does not know."""

import json
import pickle
import shutil

import numpy as np
import pytest

from circumspect.classification import Classifier
from circumspect.cli.main import main
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.furniture.other_things import make_other_thing
from circumspect.geometry import PointCloud, write_ply

CHAIRS = ("chair", "sofa", "table", "toilet")
STRANGERS = ("person", "ring", "car", "stairs")


def cloud_of(mesh, side=None):
    points = mesh.sampled(8000, 0).points_xyz
    return PointCloud(points if side is None else points * side / np.ptp(points, axis=0).max())


def lamp(number):
    return cloud_of(make_other_thing("floor_lamp", number), 1.2 + 0.04 * (number % 6))


@pytest.fixture(scope="module")
def lamps(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lamps")
    for number in range(6):
        write_ply(folder / f"lamp{number}.ply", lamp(number))
    return folder


@pytest.fixture(scope="module")
def models(lamps, tmp_path_factory):
    """The folder of own classifiers, with robot-lamp in it, and what the command printed."""
    folder = tmp_path_factory.mktemp("models")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CIRCUMSPECT_MODELS", str(folder))
        assert teach("lamp", lamps) == 0
    return folder


@pytest.fixture(autouse=True)
def _own_folder(request, monkeypatch, tmp_path):
    folder = tmp_path / "empty"
    if "models" in request.fixturenames:
        folder = request.getfixturevalue("models")
    monkeypatch.setenv("CIRCUMSPECT_MODELS", str(folder))


def teach(name, folder, *flags, pattern="*.ply"):
    files = [str(file) for file in sorted(folder.glob(pattern))]
    return main(["teach", name, *files, "--unit", "m", "--json", *flags])


@pytest.fixture(scope="module")
def taught(models):
    return Classifier.load(models / "robot-lamp.json", 1)


def test_new_objects_of_the_class_get_its_name(taught):
    for number in range(20, 24):
        answer = taught.classify(lamp(number), metric=True)
        assert (answer.label, answer.in_distribution) == ("lamp", True)


@pytest.mark.parametrize("kind", CATEGORIES)
def test_objects_of_existing_classes_are_named_as_before(taught, kind):
    before = Classifier.load("robot", 1)
    for seed in (4, 5):
        cloud = cloud_of(make_furniture(kind, seed))
        old, new = (one.classify(cloud, metric=True) for one in (before, taught))
        assert (new.label, new.in_distribution) == (old.label, old.in_distribution)
        for name, share in old.probabilities.items():
            assert new.probabilities[name] == pytest.approx(share, abs=1e-9)


def test_most_unknown_objects_stay_unknown(taught):
    shown = [cloud_of(make_other_thing(kind, seed), 1.0) for kind in STRANGERS for seed in (4, 5)]
    answers = [taught.classify(cloud, metric=True) for cloud in shown]
    assert sum(answer.in_distribution for answer in answers) <= 1


def test_copy_in_another_process_is_taught_as_well(taught):
    copy = pickle.loads(pickle.dumps(taught))
    assert copy.classes == taught.classes
    assert copy.classify(lamp(20), metric=True).label == "lamp"


def test_commands_take_it_by_name(models, lamps, capsys):
    assert main(["classify", str(lamps / "lamp1.ply"), "--unit", "m", "--model", "robot-lamp"]) == 0
    assert "lamp1.ply: lamp (" in capsys.readouterr().out
    assert main(["models", "--json"]) == 0
    last = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (last["name"], last["taught"]) == ("robot-lamp", {"lamp": 6})
    assert last["figures"][0]["measure"] == "leave-one-out accuracy"
    assert main(["models"]) == 0
    assert "taught: lamp (6" in " ".join(capsys.readouterr().out.split())
    assert main(["classify", "x.ply", "--model", "robot-lmp"]) == 2
    assert "did you mean 'robot-lamp'? shipped: robot, modelnet10; your own: robot-lamp" in (
        capsys.readouterr().err
    )


def test_scan_names_by_it(models, tmp_path, capsys):
    command = ["scan", "chair-3", "--model", "robot-lamp", "--frames", "3", "--seed", "1", "--json"]
    assert main([*command, "--out", str(tmp_path / "run")]) in (0, 1)
    assert "lamp" in json.loads(capsys.readouterr().out)["probabilities"]


def test_second_class_is_taught_to_a_taught_classifier(models, tmp_path, capsys):
    folder = tmp_path / "cars"
    folder.mkdir()
    for number in range(5):
        car = cloud_of(make_other_thing("car", number), 1.0 + 0.05 * number)
        write_ply(folder / f"{number}.ply", car)
    out = tmp_path / "both.json"
    assert teach("car", folder, "--model", "robot-lamp", "--out", str(out)) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["named"] >= 4
    assert report["furniture_after"] >= report["furniture_before"] - 1
    both = Classifier.load(out, 1)
    assert both.classes[-2:] == ("lamp", "car")
    assert both.classify(lamp(20), metric=True).label == "lamp"
    assert both.classify(cloud_of(make_other_thing("car", 9), 1.1), metric=True).label == "car"


def test_existing_file_is_overwritten_on_request_only(models, lamps, capsys):
    before = (models / "robot-lamp.json").read_bytes()
    assert teach("lamp", lamps) == 2
    assert "robot-lamp.json: exists; --replace overwrites it" in capsys.readouterr().err
    assert (models / "robot-lamp.json").read_bytes() == before
    assert teach("lamp", lamps, "--out", "robot") == 2
    assert "the name of a shipped classifier" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "pattern", "flags", "message"),
    [
        ("chair", "*", [], "the classifier names chair already"),
        ("Chair", "*", [], "the classifier names chair already"),
        ("other", "*", [], "the classifier names other already"),
        ("lamp", "lamp[0-3]*", [], "4 examples are too few; give at least 5"),
        ("a lamp", "*", [], "'a lamp' is no name of a class"),
        ("lamp", "*", ["--out", "x.onnx"], "give a name, or a file that ends in .json"),
    ],
)
def test_unsuitable_names_and_examples_are_refused(
    lamps, tmp_path, capsys, name, pattern, flags, message
):
    assert teach(name, lamps, *flags, pattern=pattern) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "empty").exists()


def test_one_object_twice_is_refused(lamps, tmp_path, capsys):
    folder = tmp_path / "twice"
    shutil.copytree(lamps, folder)
    shutil.copy(folder / "lamp2.ply", folder / "lamp9.ply")
    assert teach("lamp", folder) == 2
    assert "lamp9.ply: the same content as" in capsys.readouterr().err
    write_ply(folder / "lamp9.ply", PointCloud(lamp(2).points_xyz + np.array([0.5, 0.0, 0.0])))
    assert teach("lamp", folder) == 2
    assert "lamp9.ply: the same object as" in capsys.readouterr().err


def test_examples_of_no_one_kind_are_refused(tmp_path, capsys):
    mixed = tmp_path / "mixed"
    mixed.mkdir()
    for kind in (*CHAIRS, "bed", "monitor"):
        write_ply(mixed / f"{kind}.ply", cloud_of(make_furniture(kind, 1)))
    assert teach("thing", mixed) == 2
    assert "no more like each other than like other things" in capsys.readouterr().err
    assert not (tmp_path / "empty").exists()


def test_runs_are_examples(tmp_path, capsys):
    input_spec = Classifier.load("robot", 1).input_spec
    for number in range(5):
        run = tmp_path / f"run-{number}"
        run.mkdir()
        cloud = lamp(number)
        input_spec.bounds(cloud).hits(input_spec.surface(cloud)).save(run / "grid.npz")
    out = tmp_path / "own.json"
    runs = [str(tmp_path / f"run-{number}") for number in range(5)]
    assert main(["teach", "lamp", *runs, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "leave-one-out: " in printed
    assert f"--model {out}" in printed
    (tmp_path / "run-1" / "grid.npz").unlink()
    assert main(["teach", "lamp", *runs, "--out", str(out), "--replace"]) == 2
    assert "run-1: holds no grid.npz" in capsys.readouterr().err


def test_own_onnx_file_is_taught_beside_itself(lamps, tmp_path, capsys):
    from circumspect.classification.shipped import shipped_path

    own = tmp_path / "mine.onnx"
    shutil.copy(shipped_path("robot"), own)
    assert teach("lamp", lamps, "--model", str(own), "--out", "elsewhere") == 2
    assert f"must lie beside {own}" in capsys.readouterr().err
    assert teach("lamp", lamps, "--model", str(own)) == 0
    taught = tmp_path / "mine-lamp.json"
    assert json.loads(capsys.readouterr().out)["trained"] is None, "it has no table of examples"
    assert Classifier.load(taught, 1).classify(lamp(20), metric=True).label == "lamp"
    assert main(["calibrate", str(taught), "x.onnx", "--data", str(tmp_path)]) == 2
    assert "was taught classes; calibrate the classifier" in capsys.readouterr().err
    own.write_bytes(shipped_path("modelnet10").read_bytes())
    assert main(["classify", "x.ply", "--model", str(taught)]) == 2
    assert "is another network than the one that was taught" in capsys.readouterr().err
