"""Results are drawn, written to files, and converted to JSON types."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.spatial.transform import RigidTransform
from small_world import blind, frames, run

from circumspect.classification import CellEvidence, ConfidenceRule, Prediction
from circumspect.errors import InputError, MissingExtraError
from circumspect.evaluation import YawSweep, absolute_trajectory_error, relative_pose_error
from circumspect.geometry import Trajectory
from circumspect.grid import OccupancyGrid, RectangularGrid
from circumspect.recognition import RecognitionResult
from circumspect.runs.run_folder import result_document


@dataclass
class Results:
    """One object of each result type."""

    run: RecognitionResult
    prediction: Prediction
    grid: OccupancyGrid
    cube: OccupancyGrid
    evidence: CellEvidence
    sweep: YawSweep
    error: Any


@pytest.fixture(scope="module")
def results() -> Results:
    shots = list(frames(6))
    shots[2] = blind(shots[2])
    result = run(shots)
    grid = result.last.grid
    shares = np.array([0.5, 0.3, 0.2])
    rule = ConfidenceRule(coverage=(0.5,), probability=(0.8,))
    prediction = Prediction.from_probabilities(
        ("night_stand", "chair", "bed"), shares, coverage=0.9, rule=rule
    )
    cells = np.where(
        grid.occupied, np.linspace(-1, 2, grid.states.size).reshape(grid.states.shape), 0
    )
    states = np.zeros((4, 4, 4), np.uint8)
    states[1, 2, 3] = 2
    probabilities = np.tile(shares, (16, 5, 1))
    sweep = YawSweep(
        np.arange(16) * 22.5, probabilities, np.array([0, 0, 0, 1, 2]),
        ("night_stand", "chair", "bed"), {"grid": 1.0},
    )  # fmt: skip
    return Results(
        result, prediction, grid, OccupancyGrid(RectangularGrid((4, 4, 4)), states),
        CellEvidence(grid, prediction, "night_stand", 0.0, cells.astype(np.float32), 7), sweep,
        absolute_trajectory_error(*trajectories()),
    )  # fmt: skip


def trajectories() -> tuple[Trajectory, Trajectory]:
    places = np.random.default_rng(0).normal(size=(9, 3))
    stamps = np.arange(9.0) + 5.0
    off = places + np.linspace(0, 0.02, 9)[:, None]
    return tuple(Trajectory(stamps, RigidTransform.from_translation(p)) for p in (off, places))


PLOTS: dict[str, Callable[[Results], Any]] = {
    "prediction": lambda r: r.prediction,
    "cylindrical grid": lambda r: r.grid,
    "rectangular grid": lambda r: r.cube,
    "evidence": lambda r: r.evidence,
    "object model": lambda r: r.run.last.model,
    "cloud": lambda r: r.run.last.model.cloud(),
    "yaw sweep": lambda r: r.sweep,
    "trajectory error": lambda r: r.error,
    "run": lambda r: r.run,
}


@pytest.mark.parametrize("name", PLOTS)
def test_results_draw_into_given_or_new_axes(results, name):
    result = PLOTS[name](results)
    axes = Figure().add_subplot()
    assert result.plot(axes) is axes
    assert axes.has_data()
    new = result.plot()
    assert new is not axes
    assert new.has_data()
    new.figure.canvas.draw()


@pytest.mark.parametrize("name", PLOTS)
def test_without_matplotlib_the_extra_is_named(results, name, monkeypatch):
    result = PLOTS[name](results)
    for module in [m for m in sys.modules if m.partition(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(
        MissingExtraError, match=r'matplotlib .* pip install "circumspect\[figures\]"'
    ):
        result.plot()


@pytest.mark.parametrize("name", ["prediction", "trajectory error", "run"])
def test_records_are_saved_as_json(results, name, tmp_path):
    result = PLOTS[name](results)
    result.save(tmp_path / "result.json")
    assert json.loads((tmp_path / "result.json").read_text()) == result.to_dict()


@pytest.mark.parametrize("name", ["evidence", "object model", "yaw sweep"])
def test_other_results_turn_into_json_types_and_are_saved(results, name, tmp_path):
    result = PLOTS[name](results)
    assert json.loads(json.dumps(result.to_dict())) == result.to_dict()
    result.save(tmp_path / "result.ply")
    assert (tmp_path / "result.ply").stat().st_size > 100


def test_prediction_shows_the_bound_of_a_confident_answer(results):
    axes = results.prediction.plot()
    assert axes.get_legend().get_texts()[0].get_text() == "confident from 80 %"
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["night stand", "chair", "bed"]
    assert "not confident" in axes.get_title(loc="left")
    little = replace(results.prediction, coverage=0.1)
    assert little.plot().get_legend() is None


def test_sweeps_share_axes_in_one_style(results):
    axes = results.sweep.plot(label="ours")
    results.sweep.plot(axes, "theirs", color="red", linestyle="--")
    assert [line.get_label() for line in axes.lines] == [
        "ours: worst 60.0 %", "theirs: worst 60.0 %",
    ]  # fmt: skip
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.0, 360.0), (0.0, 100.0))
    few = replace(
        results.sweep, yaw_deg=np.array([0.0, 90.0]), probabilities=results.sweep.probabilities[:2]
    )
    assert few.plot().lines[0].get_linestyle() == "None", "nothing was measured in between"


def test_error_of_a_trajectory_keeps_that_of_each_pose(results):
    error = results.error
    assert np.sqrt((error.distances_m**2).mean()) == pytest.approx(error.rmse_m)
    assert error.stamps.tolist() == [5.0 + number for number in range(9)]
    assert not error.distances_m.flags.writeable
    assert set(error.to_dict()) >= {"poses", "rmse_m", "yaw_max_deg"}
    assert not {"stamps", "distances_m"} & set(error.to_dict())
    steps = relative_pose_error(*trajectories(), delta_frames=2)
    assert steps.stamps.tolist() == [7.0 + number for number in range(7)]


def test_document_of_a_run_is_its_dictionary_with_truth_and_times(results):
    document = result_document(results.run, {"truth": "chair"})
    assert list(document)[-1] == "milliseconds"
    assert document["truth"] == "chair"
    assert sum(document["outcomes"].values()) == 6
    assert {key: document[key] for key in results.run.to_dict()} == results.run.to_dict()


def test_a_run_without_frames_is_not_drawn():
    with pytest.raises(InputError, match="nothing to draw"):
        RecognitionResult(()).plot()
