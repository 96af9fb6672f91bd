"""`evaluate` on labelled real objects, from the file to the pictures."""

import csv
import json
import re

import numpy as np
import pytest
from made_crops import arrays_of, crop, little_rooms, write_crops
from PIL import Image

from circumspect.classification.shipped import shipped_path
from circumspect.cli.main import main

PICTURES = ("confusion.png", "reliability.png")


def run(*words):
    return main([str(word) for word in words])


@pytest.fixture(scope="module")
def rooms(tmp_path_factory):
    return write_crops(tmp_path_factory.mktemp("crops") / "rooms.npz")


@pytest.fixture(scope="module")
def evaluated(rooms, tmp_path_factory):
    out = tmp_path_factory.mktemp("results")
    assert run("evaluate", "--data", rooms, "--out", out) == 0
    return out


def test_metrics_count_every_object(evaluated):
    metrics = json.loads((evaluated / "metrics.json").read_text())
    assert metrics["objects"] == {
        "all": 7, "known_classes": 5, "other_kinds": 1, "left_out": 1
    }  # fmt: skip
    assert metrics["scale"] == "metric"
    assert metrics["command"] == "circumspect evaluate --model robot --data rooms.npz"
    assert {row["scene"] for row in metrics["per_scene"]} == {"kitchen", "office"}
    assert metrics["open_set"]["measure"] == "in_distribution_probability"
    assert 0 <= metrics["open_set"]["auroc"] <= 1


def test_every_object_has_a_line(evaluated):
    lines = [json.loads(line) for line in (evaluated / "objects.jsonl").read_text().splitlines()]
    with (evaluated / "objects.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(lines) == len(rows) == 7
    wanted = {"scene", "label", "answer", "probability", "confident", "in_distribution",
              "alternatives"}  # fmt: skip
    assert wanted <= set(lines[0])
    assert wanted <= set(rows[0])
    for line, row, label in zip(lines, rows, little_rooms()["label"], strict=True):
        assert line["label"] == row["label"] == label
        assert line["answer"] == row["answer"]
        assert float(row["probability"]) == pytest.approx(line["probability"])


def test_report_fits_80_columns_and_links_pictures_that_exist(evaluated):
    text = (evaluated / "report.md").read_text()
    assert max(map(len, text.splitlines())) <= 80
    for heading in ("Accuracy", "By room", "By class", "Answers", "Confidence", "Probability",
                    "Open set"):  # fmt: skip
        assert f"\n## {heading}\n" in text
    assert "armchair (1, chair or sofa)" in text
    linked = re.findall(r"!\[.*\]\((.*)\)", text)
    assert set(PICTURES) <= set(linked)
    assert sorted(linked) == sorted(path.name for path in evaluated.glob("*.png"))


def test_pictures_are_not_empty(evaluated):
    for path in evaluated.glob("*.png"):
        picture = np.asarray(Image.open(path).convert("L"))
        assert min(picture.shape) >= 300
        assert (picture < 128).mean() > 0.002, f"{path.name} is blank"
        assert (picture > 240).mean() > 0.1


def test_the_report_is_printed_and_json_alone_where_asked_for(rooms, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert run("evaluate", "--data", rooms, "--out", tmp_path, "--scale", "unknown") == 0
    printed = capsys.readouterr().out
    command = "circumspect evaluate --model robot --data rooms.npz --scale unknown"
    lines = [line.rstrip() for line in printed.splitlines()]
    assert lines[:3] == ["Real objects", "", command]
    assert not any(sign in printed for sign in ("```", "|", "## "))
    assert max(map(len, lines[:-1])) <= 80
    assert run("evaluate", "--data", rooms, "--out", tmp_path, "--json") == 0
    printed = capsys.readouterr().out
    assert json.loads(printed) == json.loads((tmp_path / "metrics.json").read_text())


def test_errors_are_drawn_on_pages_and_old_pages_are_removed(tmp_path, capsys):
    """Chairs labelled as bathtubs are errors."""
    labels = ["bathtub"] * 26
    clouds = [crop("chair", 60 + k % 3, 300) for k in range(26)]
    many = write_crops(tmp_path / "many.npz", arrays_of(clouds, labels, ["room"] * 26))
    out = tmp_path / "out"
    assert run("evaluate", "--data", many, "--out", out) == 0
    wrong = 26 - json.loads((out / "metrics.json").read_text())["overall"]["accuracy"]["hits"]
    assert wrong == 26
    assert {path.name for path in out.glob("errors*.png")} == {"errors.png", "errors-2.png"}
    (out / "errors-of-mine.png").write_text("not ours")
    few = write_crops(tmp_path / "few.npz", arrays_of(clouds[:2], labels[:2], ["room"] * 2))
    assert run("evaluate", "--data", few, "--out", out) == 0
    assert {path.name for path in out.glob("errors*.png")} == {"errors.png", "errors-of-mine.png"}


def test_several_files_are_one_evaluation(rooms, tmp_path, capsys):
    second = write_crops(
        tmp_path / "attic.npz", arrays_of([crop("desk", 1)], ["desk"], ["kitchen"])
    )
    assert run("evaluate", "--data", rooms, second, "--out", tmp_path / "out", "--json") == 0
    metrics = json.loads(capsys.readouterr().out)
    assert list(metrics["per_source"]) == ["attic", "rooms"]
    assert metrics["objects"]["all"] == 8
    kitchens = [row["source"] for row in metrics["per_scene"] if row["scene"] == "kitchen"]
    assert kitchens == ["attic", "rooms"]


def test_a_file_of_other_kinds_alone(tmp_path, capsys):
    arrays = arrays_of([crop("chair", 1)], ["lamp"], [""])
    lamps = write_crops(tmp_path / "lamps.npz", arrays)
    assert run("evaluate", "--data", lamps, "--out", tmp_path / "out") == 0
    assert "there are no objects of known classes" in capsys.readouterr().out
    assert (tmp_path / "out" / "confusion.png").is_file()


def test_an_own_classifier_is_named(rooms, tmp_path, capsys):
    own = tmp_path / "own.onnx"
    own.write_bytes(shipped_path("robot").read_bytes())
    words = ("evaluate", "--model", own, "--data", rooms, "--out", tmp_path / "out", "--json")
    assert run(*words) == 0
    metrics = json.loads(capsys.readouterr().out)
    assert metrics["model"] == "own.onnx"
    assert metrics["command"] == "circumspect evaluate --model own.onnx --data rooms.npz"


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"points": None}, "lacks points"),
        ({"offsets": None}, "lacks offsets"),
        ({"offsets": np.array([0, 3, 2, 4, 5, 6, 7, 8])}, "offsets must go from 0"),
        ({"label": np.array([["chair"] * 7], object)}, "label holds an array of object"),
        ({"points": np.full((9000, 3), np.nan, "f4")}, "offsets must go from 0 to 9000"),
    ],
)
def test_broken_files_are_refused_in_one_line(tmp_path, capsys, change, why):
    arrays = {**little_rooms(), **change}
    path = tmp_path / "broken.npz"
    np.savez(path, **{key: value for key, value in arrays.items() if value is not None})
    assert run("evaluate", "--data", path, "--out", tmp_path / "out") == 2
    stderr = capsys.readouterr().err
    assert why in stderr
    assert stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_truncated_file_is_refused_in_one_line(rooms, tmp_path, capsys):
    (tmp_path / "cut.npz").write_bytes(rooms.read_bytes()[:3000])
    assert run("evaluate", "--data", tmp_path / "cut.npz", "--out", tmp_path / "out") == 2
    stderr = capsys.readouterr().err
    assert "cut.npz" in stderr
    assert stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("flags", "why"),
    [
        (("--yaw", "0"), "leave --yaw out"),
        (("--yaw-count", 8), "leave --yaw-count out"),
        (("--corrupt",), "leave --corrupt out"),
        (("--split", "test"), "leave --split out"),
        (("--margin", 1.2), "leave --margin out"),
    ],
)
def test_flags_of_complete_objects_are_refused(rooms, tmp_path, capsys, flags, why):
    assert run("evaluate", "--data", rooms, "--out", tmp_path / "out", *flags) == 2
    assert why in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_sets_and_real_objects_are_not_mixed(rooms, data, tmp_path, capsys):
    assert run("evaluate", "--data", rooms, data, "--out", tmp_path / "out") == 2
    assert "evaluate them one after the other" in capsys.readouterr().err
    assert run("evaluate", "--data", data, data, "--out", tmp_path / "out") == 2
    assert "one set at a time, not 2" in capsys.readouterr().err
    assert run("evaluate", "--data", data, "--scale", "unknown", "--out", tmp_path / "out") == 2
    assert "--scale goes with files of labelled real objects" in capsys.readouterr().err


def test_an_unwritable_folder_is_refused_before_the_work(rooms, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert run("evaluate", "--data", rooms, "--out", tmp_path / "file" / "x") == 2
    assert "file" in capsys.readouterr().err


def test_without_matplotlib_the_report_is_written(rooms, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    assert run("evaluate", "--data", rooms, "--out", tmp_path) == 0
    assert 'no pictures: matplotlib is not installed; get it with: pip install "' in (
        capsys.readouterr().err
    )
    assert "![" not in (tmp_path / "report.md").read_text()


@pytest.mark.parametrize("label", ["unknown", "armchair"])
def test_ambiguous_labels_alone_are_refused_before_the_work(label, tmp_path, capsys):
    arrays = arrays_of([crop("chair", 1)], [label], ["hall"])
    crops, out = write_crops(tmp_path / "rooms.npz", arrays), tmp_path / "out"
    assert run("evaluate", "--data", crops, "--out", out) == 2
    message = capsys.readouterr().err
    assert f"({label})" in message
    assert message.count("\n") == 1
    assert not out.exists()
