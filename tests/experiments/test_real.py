"""Classifiers compared on real objects: with any predictor, resumable, and without training."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from experiment_watcher import Watched
from hypothesis import given
from hypothesis import strategies as st
from little_furniture import furniture
from made_crops import arrays_of, crop, other_crop, write_crops
from two_kinds import ByHeight

from circumspect.cli.main import main
from circumspect.datasets.label_meaning import LabelUse
from circumspect.datasets.point_pack import write_point_pack
from circumspect.errors import InputError, WeightsError
from circumspect.evaluation.crop_answers import CropAnswer
from circumspect_experiments import RealObjects, real, reproduce_real
from circumspect_experiments.paired_comparison import compared_to_first, leave_one_room_out
from circumspect_experiments.real import named_contenders


class Upside(ByHeight):
    """Always answers the opposite."""

    def probabilities(self, inputs, contexts=None):
        return super().probabilities(inputs)[:, ::-1]


class Others(ByHeight):
    classes = ("low", "high")


PREDICTORS = {"good.onnx": ByHeight(), "bad.onnx": Upside(), "others.onnx": Others()}


def rooms(folder, name="rooms.npz"):
    """Beams and boards in two rooms, and a thing of another kind."""
    sizes = {"flat": (2.0, 0.3, 0.1), "tall": (0.3, 0.2, 2.0)}
    rng = np.random.default_rng(0)
    labels = ["flat", "tall", "flat", "tall"]
    clouds = [(rng.random((400, 3)) - 0.5) * sizes[label] for label in labels]
    arrays = arrays_of(
        [*clouds, other_crop()], [*labels, "lamp"], ["hall", "hall", "attic", "attic", "attic"]
    )
    return write_crops(folder / name, arrays)


@pytest.fixture
def loaded(tmp_path, monkeypatch):
    """Contenders that are loaded from files in name only."""
    for name in PREDICTORS:
        (tmp_path / name).write_text(name)
    monkeypatch.setattr(
        "circumspect_experiments.real.load_predictor", lambda path: PREDICTORS[path.name]
    )
    return tmp_path


def contenders(folder, *names):
    return {name: folder / f"{name}.onnx" for name in names}


def test_contenders_are_compared_object_by_object(loaded):
    experiment = RealObjects(contenders=contenders(loaded, "good", "bad"))
    crops, out = rooms(loaded), loaded / "out"
    document = reproduce_real([crops], experiment, out, Watched())
    good, bad = (document["contenders"][name]["overall"]["accuracy"] for name in ("good", "bad"))
    assert (good["hits"], good["objects"]) == (4, 4)
    assert bad["hits"] == 0
    assert document["paired"] == {"bad": {"gained": 0, "lost": 4, "p": pytest.approx(0.125)}}
    choice = document["leave_one_room_out"]
    assert [row["chosen"] for row in choice["rooms"]] == ["good", "good"]
    assert choice["chosen"]["hits"] == 4
    text = (out / "real.md").read_text()
    # A command to copy is not wrapped.
    assert max(len(line) for line in text.splitlines() if document["command"] not in line) <= 80
    assert json.loads((out / "real.json").read_text()) == document
    assert document["command"] in text.replace(" \\\n ", "")
    assert str(loaded) not in text


def test_existing_answers_are_kept(loaded):
    crops, out, first, again = rooms(loaded), loaded / "out", Watched(), Watched()
    experiment = RealObjects(contenders=contenders(loaded, "good", "bad"))
    document = reproduce_real([crops], experiment, out, first)
    assert first.steps == ["good, rooms", "bad, rooms"]
    assert reproduce_real([crops], experiment, out, again) == document
    assert again.steps == [], "nothing is measured again"
    more, third = rooms(loaded, "more.npz"), Watched()
    both = reproduce_real([crops, more], experiment, out, third)
    assert third.steps == ["good, more", "bad, more"]
    assert both["contenders"]["good"]["overall"]["accuracy"]["objects"] == 8


def test_an_interrupted_comparison_resumes(loaded, monkeypatch):
    crops, out = rooms(loaded), loaded / "out"
    experiment = RealObjects(contenders=contenders(loaded, "good", "bad"))

    def interrupted(self, inputs, contexts=None):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Upside, "probabilities", interrupted)
        with pytest.raises(KeyboardInterrupt):
            reproduce_real([crops], experiment, out, Watched())
    rest = Watched()
    reproduce_real([crops], experiment, out, rest)
    assert rest.steps == ["bad, rooms"]


@pytest.mark.parametrize("text", ["{", "[]", "[1, 2, 3, 4, 5]", "{}", "null"])
def test_broken_answers_name_the_folder_to_remove(loaded, text):
    crops, out = rooms(loaded), loaded / "out"
    experiment = RealObjects(contenders=contenders(loaded, "good"))
    reproduce_real([crops], experiment, out, Watched())
    (out / "good" / "rooms" / "result.json").write_text(text)
    with pytest.raises(InputError, match="remove the folder") as error:
        reproduce_real([crops], experiment, out, Watched())
    assert "\n" not in str(error.value)


def test_other_objects_or_weights_are_not_mixed_in(loaded):
    crops, out = rooms(loaded), loaded / "out"
    experiment = RealObjects(contenders=contenders(loaded, "good"))
    reproduce_real([crops], experiment, out, Watched())
    (loaded / "good.onnx").write_text("another training")
    with pytest.raises(InputError, match="other weights"):
        reproduce_real([crops], experiment, out, Watched())
    (loaded / "good.onnx").write_text("good.onnx")
    write_crops(crops, arrays_of([crop("chair", 1)], ["flat"], ["hall"]))
    with pytest.raises(InputError, match="other data"):
        reproduce_real([crops], experiment, out, Watched())


def test_contenders_of_other_classes_are_refused_before_the_work(loaded):
    watched = Watched()
    experiment = RealObjects(contenders=contenders(loaded, "good", "others"))
    with pytest.raises(InputError, match="others knows low, high, but good knows flat, tall"):
        reproduce_real([rooms(loaded)], experiment, loaded / "out", watched)
    assert watched.steps == []


def test_training_is_refused_with_an_alternative(loaded):
    experiment = RealObjects(nets=("planes",), contenders={})
    with pytest.raises(InputError, match="--nets planes: needs --data"):
        reproduce_real([rooms(loaded)], experiment, loaded / "out", Watched())


def test_a_comparison_without_contenders_is_refused():
    with pytest.raises(InputError, match="nothing to compare"):
        RealObjects(contenders={})
    with pytest.raises(InputError, match="is the name of a network"):
        RealObjects(nets=("planes",), contenders={"planes": "a.onnx"})


class TestNamedContenders:
    def test_names_and_files(self):
        found = named_contenders(["own=runs/own", "other.onnx"])
        assert list(found) == ["robot", "own", "other"]
        assert found["own"].name == "own"

    @pytest.mark.parametrize("word", ["=a.onnx", "own=", "", "robot=a.onnx"])
    def test_unknown_contenders_are_refused(self, word):
        with pytest.raises(InputError, match="--contenders"):
            named_contenders([word])

    def test_a_shipped_name_selects_its_file(self):
        found = named_contenders(["modelnet10"])
        assert found["modelnet10"].name == "modelnet10.onnx"

    def test_repeated_names_are_refused(self):
        with pytest.raises(InputError, match="stands for another classifier already"):
            named_contenders(["own=a.onnx", "own=b.onnx"])


def row(correct, scenes):
    """Answers that are correct or not, in rooms."""
    return [
        CropAnswer(
            source="file", scene=scene, name="0", label="a", use=LabelUse.KNOWN_CLASS,
            true_class="a", answer="a" if right else "b", probabilities={"a": 0.5, "b": 0.5},
            confident=False, reason="", in_distribution=True, in_distribution_probability=None,
            distance=None, alternatives={},
        )
        for right, scene in zip(correct, scenes, strict=True)
    ]  # fmt: skip


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.sampled_from("abc")), min_size=1))
def test_leave_one_room_out_counts_the_choice_of_the_other_rooms(objects):
    first, second, scenes = (list(column) for column in zip(*objects, strict=True))
    found = leave_one_room_out({"one": row(first, scenes), "two": row(second, scenes)})
    names = sorted(set(scenes))
    if len(names) < 2:
        assert found["rooms"] == []
        return
    correct = 0
    for name, kept in zip(names, found["rooms"], strict=True):
        sums = [
            sum(hit for hit, scene in zip(hits, scenes, strict=True) if scene != name)
            for hits in (first, second)
        ]
        best = (first, second)[int(sums[1] > sums[0])]
        assert kept["scene"] == name
        correct += sum(hit for hit, scene in zip(best, scenes, strict=True) if scene == name)
    assert found["chosen"]["hits"] == correct
    assert found["chosen"]["objects"] == len(objects)


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1))
def test_gained_and_lost_explain_the_difference(pairs):
    first, second = (list(column) for column in zip(*pairs, strict=True))
    scenes = ["room"] * len(pairs)
    found = compared_to_first({"one": row(first, scenes), "two": row(second, scenes)})["two"]
    assert found["gained"] - found["lost"] == sum(second) - sum(first)
    assert 0 < found["p"] <= 1


def test_the_command_compares_the_shipped_classifier_with_a_copy(tmp_path, capsys):
    from circumspect.classification.shipped import shipped_path

    (tmp_path / "copy.onnx").write_bytes(shipped_path("robot").read_bytes())
    clouds = [crop("chair", 1), crop("sofa", 2), other_crop()]
    crops = write_crops(
        tmp_path / "rooms.npz", arrays_of(clouds, ["chair", "sofa", "lamp"], ["a", "b", "b"])
    )
    words = ("reproduce", "real", "--crops", crops, "--contenders", tmp_path / "copy.onnx")
    assert main([*map(str, words), "--out", str(tmp_path / "out"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document["contenders"]) == ["robot", "copy"]
    assert document["paired"]["copy"] == {"gained": 0, "lost": 0, "p": 1.0}
    assert document["contenders"]["copy"]["open_set"]["measure"] == "in_distribution_probability"


def test_a_rival_is_trained_on_scans_and_compared(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(real, "REPLICAS", 1)
    monkeypatch.setenv("CIRCUMSPECT_CACHE", str(tmp_path / "cache"))
    data, out = tmp_path / "packs", tmp_path / "out"
    data.mkdir()
    write_point_pack(data / "train.npz", furniture(2, 0))
    clouds = [crop("chair", 1), crop("sofa", 2)]
    crops = write_crops(tmp_path / "rooms.npz", arrays_of(clouds, ["chair", "sofa"], ["a", "b"]))
    words = ("reproduce", "real", "--crops", crops, "--nets", "voxnet", "--data", data)
    assert main([*map(str, words), "--epochs", "1", "--out", str(out), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document["contenders"]) == ["robot", "voxnet"]
    assert document["command"] == (
        "circumspect reproduce real --crops rooms.npz --nets voxnet --data packs --epochs 1 "
        "--precision fp32 --seed 0"
    )
    assert (out / "voxnet" / "training" / "epochs.csv").exists()


def test_a_missing_contender_is_found_before_the_training(tmp_path):
    watched = Watched()
    experiment = RealObjects(
        nets=("voxnet",), contenders={"own": tmp_path / "none.onnx"}, data=tmp_path / "packs"
    )
    with pytest.raises(WeightsError, match="no such file"):
        reproduce_real([rooms(tmp_path)], experiment, tmp_path / "out", watched)
    assert watched.name == ""


def test_the_command_names_shipped_classifiers():
    experiment = RealObjects(
        contenders=named_contenders(["modelnet10", "mine=modelnet10", "own.onnx"])
    )
    assert experiment.command_on([Path("rooms.npz")]).endswith(
        "--contenders modelnet10 mine=modelnet10 own=own.onnx"
    )


def test_ambiguous_labels_alone_are_refused_before_the_work(loaded):
    arrays = arrays_of([crop("chair", 1)], ["unknown"], ["hall"])
    crops, watched = write_crops(loaded / "nothing.npz", arrays), Watched()
    experiment = RealObjects(contenders=contenders(loaded, "good"))
    with pytest.raises(InputError, match=r"no label .* says what the answer should be \(unknown"):
        reproduce_real([crops], experiment, loaded / "out", watched)
    assert watched.steps == []


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("real",), "real needs --crops"),
        (("real", "--crops", "x.npz", "--nets", "voxnet"), "--nets of real needs --data"),
        (("real", "--crops", "x.npz", "--nets", "voxne", "--data", "y"), "did you mean voxnet?"),
        (("real", "--crops", "x.npz", "--only", "voxnet"), "--only does not go with real"),
        (("real", "--crops", "x.npz", "--robot", "y"), "--robot does not go with real"),
        (("real", "--crops", "x.npz", "--contenders", "own="), "give NAME=FILE"),
        (("real", "--crops", "none.npz"), "none.npz: does not exist"),
        (("rivals", "--data", "y", "--crops", "x.npz"), "--crops goes with real"),
        (("table2",), "table2 needs --data"),
    ],
)
def test_conflicting_flags_are_refused(words, why, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["reproduce", *words]) == 2
    reported = capsys.readouterr().err
    assert why in reported
    assert reported.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
