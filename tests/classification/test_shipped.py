"""Shipped classifiers are selected by name, and files by their path."""

from __future__ import annotations

import copy
import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification import SHIPPED, Classifier, OnnxClassifier, shipped_path
from circumspect.classification.example_table import (
    examples_path,
    nearest_examples,
    network_of,
    shipped_examples,
)
from circumspect.classification.shipped import DEFAULT, model_path, shipped_name
from circumspect.errors import WeightsError
from circumspect.evaluation.predictor import load_predictor
from circumspect.furniture import make_furniture

MAX_BYTES = 8_000_000


def grids(classifier: OnnxClassifier) -> np.ndarray:
    return classifier.input_spec.inputs(make_furniture("chair", 3).sampled(20_000, 0))


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_classifier_loads_by_name(name: str) -> None:
    classifier = Classifier.load(name, threads=1)
    assert {"chair", "sofa", "table"} <= set(classifier.classes)
    assert classifier.classify(make_furniture("chair", 3).sampled(20_000, 0)).label == "chair"
    assert load_predictor(name, threads=1).classes == classifier.classes


@pytest.mark.parametrize("name", SHIPPED)
def test_every_weights_file_is_small(name: str) -> None:
    assert shipped_path(name).stat().st_size <= MAX_BYTES


def test_robot_is_the_default() -> None:
    assert DEFAULT == next(iter(SHIPPED)) == "robot"
    default, named = Classifier.load(threads=1), Classifier.load("robot", threads=1)
    assert default.description == named.description
    assert load_predictor(threads=1).training == named.training


def test_a_name_takes_precedence_over_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copy(shipped_path("modelnet10"), tmp_path / "robot")
    monkeypatch.chdir(tmp_path)
    shipped = Classifier.load("robot", threads=1).description
    own = Classifier.load("modelnet10", threads=1).description
    assert Classifier.load("robot", threads=1).description == shipped
    for file in ("./robot", Path("robot"), tmp_path / "robot", str(tmp_path / "robot")):
        assert Classifier.load(file, threads=1).description == own
        assert shipped_name(file) is None
        assert model_path(file) == Path(file)


def test_a_file_without_a_suffix_is_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(shipped_path("modelnet10"), tmp_path / "mine")
    monkeypatch.chdir(tmp_path)
    assert len(Classifier.load("mine", threads=1).classes) == 10


@pytest.mark.parametrize(
    ("model", "message"),
    [
        ("robto", "no classifier 'robto'; did you mean 'robot'? shipped: robot, modelnet10; or "
                  "give an ONNX file"),
        ("Robot", "no classifier 'Robot'; did you mean 'robot'? "),
        ("modelnet40", "no classifier 'modelnet40'; did you mean 'modelnet10'? "),
        ("zebra", "no classifier 'zebra'; shipped: robot, modelnet10; or give an ONNX file"),
        ("", "no classifier ''; shipped: robot, modelnet10"),
        ("robot.onnx", "robot.onnx: no such file; did you mean 'robot'? shipped: robot, modelnet10"),
        ("nowhere/robot.onnx", "nowhere/robot.onnx: no such file; shipped: robot, modelnet10"),
        (Path("robto"), "robto: no such file; "),
    ],
)  # fmt: skip
def test_an_unknown_name_suggests_near_ones(
    model: str | Path, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for load in (Classifier.load, load_predictor):
        with pytest.raises(WeightsError) as error:
            load(model)
        assert str(error.value).startswith(message)
        assert "\n" not in str(error.value)


def test_a_folder_is_no_classifier(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "runs").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(WeightsError, match=r"runs: is a folder; .* circumspect export makes"):
        Classifier.load("runs")
    with pytest.raises(WeightsError, match=r"runs: holds no best\.safetensors; train first"):
        load_predictor("runs")


@given(text=st.text(max_size=20).filter(lambda text: text not in SHIPPED and "\0" not in text))
def test_any_other_text_is_a_path(text: str) -> None:
    assert shipped_name(text) is None
    assert model_path(text) == Path(text)


def test_a_path_to_an_unknown_name_is_an_error() -> None:
    with pytest.raises(WeightsError, match="did you mean 'robot'"):
        shipped_path("robots")
    with pytest.raises(WeightsError, match="no classifier 'zebra'"):
        shipped_examples("zebra")


def test_a_missing_shipped_file_says_to_install_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("circumspect.classification.shipped.WEIGHTS", str(tmp_path))
    with pytest.raises(WeightsError, match="'robot' is missing; install circumspect again"):
        Classifier.load()


@pytest.mark.parametrize("name", SHIPPED)
def test_pickled_copies_load_the_shipped_file_from_any_folder(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    classifier = Classifier.load(name, threads=1)
    expected = classifier.probabilities(grids(classifier))
    (tmp_path / name).write_text("another file of this name")
    monkeypatch.chdir(tmp_path)
    for copied in (copy.deepcopy(classifier), pickle.loads(pickle.dumps(classifier))):
        assert copied.description == classifier.description
        np.testing.assert_array_equal(copied.probabilities(grids(classifier)), expected)


def test_a_copied_file_has_the_table_of_the_shipped_one(tmp_path: Path) -> None:
    shutil.copy(shipped_path("modelnet10"), tmp_path / "copy.onnx")
    cloud = make_furniture("chair", 3).sampled(20_000, 0)
    for model in ("modelnet10", tmp_path / "copy.onnx"):
        assert nearest_examples(Classifier.load(model, threads=1), cloud)[0].label == "chair"


@pytest.mark.parametrize("name", SHIPPED)
def test_a_table_beside_shipped_weights_is_of_these_weights(name: str) -> None:
    if not examples_path(shipped_path(name)).is_file():
        pytest.skip(f"{name} ships without a table of training objects")
    assert shipped_examples(name).network == network_of(Classifier.load(name, threads=1))
