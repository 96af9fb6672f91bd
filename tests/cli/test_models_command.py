"""The table of classifiers, and the flag that selects one."""

from __future__ import annotations

import json
import shutil
import typing
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from circumspect.classification import SHIPPED, shipped_path
from circumspect.classification.model_card import SHARE, CardFigure, ModelCard, card_path
from circumspect.classification.model_facts import ModelFacts
from circumspect.classification.shipped import DEFAULT
from circumspect.cli import model_flag
from circumspect.cli.main import COMMANDS, command, main, parsed
from circumspect.furniture import make_furniture
from circumspect.ros.node_settings import NodeSettings

NAMING = {
    "classify": ("x.ply",), "explain": ("x.ply",), "scan": ("chair",), "demo": (),
    "replay": ("x.mcap",), "view": ("run",),
}  # fmt: skip
"""Commands that classify objects, with their arguments."""


def run(*words: object) -> int:
    return main([str(word) for word in words])


@pytest.fixture
def own(tmp_path: Path) -> Path:
    return Path(shutil.copy(shipped_path("modelnet10"), tmp_path / "own.onnx"))


class TestModels:
    def test_the_table_lists_both_in_80_columns(
        self, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("COLUMNS", "80")
        assert run("models") == 0
        out, err = capsys.readouterr()
        lines = out.splitlines()
        assert max(map(len, lines)) <= 80
        assert lines[0].split() == [
            "name",
            "classes",
            "size",
            "network",
            "trained",
            "on",
            "figures",
        ]
        assert [name for name in SHIPPED if any(line.startswith(f"{name} ") for line in lines)] == [
            "robot", "modelnet10",
        ]  # fmt: skip
        assert "Default: robot; of evaluate and reproduce: modelnet10." in out
        assert err == ""

    def test_json_is_one_object_a_line_and_nothing_else(
        self, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run("models", "--json") == 0
        out, err = capsys.readouterr()
        records = [json.loads(line) for line in out.splitlines()]
        assert [record["name"] for record in records] == list(SHIPPED)
        assert [record["default"] for record in records] == [True, False]
        assert err == ""
        modelnet10 = records[1]
        assert modelnet10["training_objects"] == 3991
        assert "objects" not in modelnet10["training_settings"]
        assert modelnet10["figures"][0]["unit"] == SHARE

    def test_the_figures_are_those_of_the_card(self, capsys: pytest.CaptureFixture[str]) -> None:
        card = ModelFacts.load("modelnet10").card
        assert card is not None
        assert run("models", "modelnet10") == 0
        out = capsys.readouterr().out
        assert max(map(len, out.splitlines())) <= 80
        for figure in card.figures:
            assert f"\n{figure.text} " in out
            assert figure.measure in " ".join(out.split())

    def test_a_classifier_without_figures_shows_a_dash(
        self, own: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run("models", own) == 0
        out, err = capsys.readouterr()
        rows = dict(line.split(None, 1) for line in out.splitlines() if line[0] != " ")
        assert rows["figures"].strip() == "–"
        assert "3,991 objects, 32 epochs" in rows["training"]
        assert "bathtub, bed" in out
        assert err == ""

    def test_figures_beside_an_own_file_are_shown(
        self, own: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        figure = CardFigure("accuracy", 0.5, SHARE, "my set", "circumspect evaluate")
        ModelCard(ModelFacts.load(own).sha256, (figure,)).save(card_path(own))
        assert run("models", own, "--json") == 0
        record = json.loads(capsys.readouterr().out)
        assert (record["shipped"], record["default"], record["summary"]) == (False, False, None)
        assert record["figures"][0]["value"] == 0.5

    def test_figures_of_another_file_are_not_shown(
        self, own: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        figure = CardFigure("accuracy", 0.5, SHARE, "my set", "circumspect evaluate")
        ModelCard("0" * 64, (figure,)).save(card_path(own))
        assert run("models", own) == 0
        out, err = capsys.readouterr()
        assert "50.0 %" not in out
        assert "own.onnx: the figures beside it are of another file" in err

    def test_a_broken_classifier_does_not_hide_the_other(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        shutil.copy(shipped_path("modelnet10"), tmp_path / "modelnet10.onnx")
        monkeypatch.setattr("circumspect.classification.shipped.WEIGHTS", str(tmp_path))
        assert run("models", "--json") == 1
        out, err = capsys.readouterr()
        assert json.loads(out)["name"] == "modelnet10"
        assert err == (
            "circumspect: the shipped classifier 'robot' is missing; install circumspect again\n"
        )

    @pytest.mark.parametrize(
        ("model", "message"),
        [
            ("robto", "did you mean 'robot'?"), ("none.onnx", "no such file"),
            (".", "is a folder"), ("text.onnx", "not an ONNX network"), ("", "no classifier ''"),
        ],
    )  # fmt: skip
    def test_a_file_that_is_no_classifier_is_refused(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str], model: str, message: str,
    ) -> None:  # fmt: skip
        (tmp_path / "text.onnx").write_text("hello")
        monkeypatch.chdir(tmp_path)
        assert run("models", model) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1
        assert message in err


class TestModelFlag:
    def test_the_names_are_those_of_the_registry(self) -> None:
        assert tuple(SHIPPED) == model_flag.NAMES
        assert model_flag.ROBOT == NodeSettings().model == DEFAULT

    @pytest.mark.parametrize("name", NAMING)
    def test_robot_is_the_default_where_objects_are_named(self, name: str) -> None:
        assert parsed(name, NAMING[name]).model == "robot"
        chosen = parsed(name, [*NAMING[name], "--model", "modelnet10"])
        assert chosen.model == "modelnet10"

    def test_modelnet10_is_the_default_of_evaluations(self) -> None:
        # What it is depends on the data: modelnet10 for sets, robot for real objects.
        assert parsed("evaluate", ["--data", "ModelNet10"]).model is None
        assert parsed("evaluate", ["--data", "x", "--model", "robot"]).model == "robot"

    def test_the_node_takes_names_too(self) -> None:
        assert parsed("ros2", []).node.model == "robot"
        assert parsed("ros2", ["--model", "modelnet10"]).node.model == "modelnet10"
        assert NodeSettings.from_parameters({"model": "own.onnx"}).model == "own.onnx"

    @pytest.mark.parametrize("name", [*NAMING, "evaluate", "ros2"])
    def test_the_help_states_the_default(
        self, name: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        with pytest.raises(SystemExit):
            run(name, "--help")
        help_text = " ".join(capsys.readouterr().out.replace("│", " ").split())
        wanted = "by default modelnet10" if name == "evaluate" else "(default: robot)"
        assert wanted in help_text.partition("--model")[2]
        assert "circumspect models" in help_text

    @pytest.mark.parametrize("name", [*NAMING, "evaluate", "ros2"])
    def test_the_old_flag_is_refused(self, name: str, capsys: pytest.CaptureFixture[str]) -> None:
        with pytest.raises(SystemExit) as stop:
            run(name, *NAMING.get(name, ()), "--weights", "own.onnx")
        assert stop.value.code == 2
        assert "--weights" in capsys.readouterr().err

    @pytest.mark.parametrize("name", COMMANDS)
    def test_no_command_has_a_flag_for_weights(self, name: str) -> None:
        kind = command(name)
        names = [field.name for field in fields(kind)]
        positional = "Positional" in repr(typing.get_type_hints(kind, include_extras=True))
        assert "weights" not in names or (name == "export" and positional)

    @pytest.mark.parametrize("name", ["classify", "explain"])
    def test_an_unknown_name_is_refused(
        self, name: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run(name, "x.ply", "--model", "robto") == 2
        assert capsys.readouterr() == (
            "",
            "circumspect: no classifier 'robto'; did you mean 'robot'? shipped: robot, modelnet10; "
            "or give an ONNX file\n",
        )

    def test_classify_answers_by_the_model_that_is_named(
        self, own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        file = tmp_path / "chair.npy"
        np.save(file, make_furniture("chair", 3).sampled(20_000, 0).points_xyz)
        answers = []
        for flags in ((), ("--model", "robot"), ("--model", "modelnet10"), ("--model", own)):
            assert run("classify", file, "--json", "--threads", 1, *flags) == 0
            record = json.loads(capsys.readouterr().out)
            assert record["label"] == "chair"
            answers.append(record["probabilities"])
        default, robot, modelnet10, copied = answers
        assert default == robot
        assert modelnet10 == copied
        assert len(modelnet10) == 10
        assert modelnet10["chair"] > 0.9

    def test_explain_takes_the_table_beside_the_model(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        from circumspect.classification import evidence

        monkeypatch.setattr(evidence.cell_evidence, "__defaults__", (None, (1.0,), None))
        file = tmp_path / "chair.npy"
        np.save(file, make_furniture("chair", 3).sampled(20_000, 0).points_xyz)
        words = ("explain", file, "--out", tmp_path, "--json", "--model", "modelnet10")
        assert run(*words) == 0
        record = json.loads(capsys.readouterr().out)
        assert [near["label"] for near in record["nearest"]] == ["chair"] * 5


def test_runs_record_the_model_and_the_hash_of_its_file(
    own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mujoco", reason="needs the extra sim")
    recorded = {}
    for name, model in (("one", "modelnet10"), ("two", str(own)), ("three", "robot")):
        words = ("scan", "chair-3", "--start", 40, "--seed", 5, "--frames", 1, "--json")
        run(*words, "--model", model, "--out", tmp_path / name)
        config = json.loads((tmp_path / name / "config.json").read_text())
        recorded[model] = config["classifier"]
    capsys.readouterr()
    assert recorded["modelnet10"]["model"] == "modelnet10"
    assert recorded[str(own)] == {**recorded["modelnet10"], "model": str(own)}
    assert recorded["robot"]["sha256"] == ModelFacts.load("robot").sha256
