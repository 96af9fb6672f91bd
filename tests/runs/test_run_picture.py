from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from small_world import blind, frames, run

from circumspect.classification import Prediction
from circumspect.geometry import PlanarPose, Trajectory
from circumspect.grid import OccupancyGrid
from circumspect.grid.grid_plot import MARGIN_ROWS
from circumspect.planning import NextView
from circumspect.recognition import RecognitionResult
from circumspect.runs import RunPath, picture
from circumspect.runs.panels import draw_probabilities, draw_shares
from circumspect.runs.picture import captions, draw_run
from circumspect.runs.plan_panel import LEGEND_LINES, LEGEND_WIDTH, MISSED_COLOUR, draw_plan
from circumspect.runs.run_path import camera_path


@pytest.fixture(scope="module")
def result() -> RecognitionResult:
    shots = list(frames(6))
    shots[2] = blind(shots[2])
    return run(shots)


def full_path(result: RecognitionResult) -> RunPath:
    path = camera_path(result)
    stamps = np.array([step.stamp for step in result.steps])
    return RunPath(
        stamps=stamps,
        driven_m=np.linspace(0, 4.5, len(stamps)),
        odometry=path,
        truth=path,
        views=(
            NextView(PlanarPose(1.2, 0.0, 1.5), (0.3, 0.0), (1.0, 0.0), "along the normal"),
            NextView(PlanarPose(0.0, 1.3, 3.1), (0.0, 0.3), None, "on the circle"),
        ),
        missed=(NextView(PlanarPose(-1.2, 0.0, 0.0), (-0.3, 0.0), None, "on the circle"),),
        walls_xy=(np.array([[2.0, -2], [2.2, -2], [2.2, 2], [2, 2], [2, -2]]),),
    )


def axes(inches: float = 6.0):
    figure = Figure(figsize=(inches, inches))
    FigureCanvasAgg(figure)
    return figure.add_subplot()


def labels(panel) -> list[str]:
    return [text.get_text() for text in panel.get_legend().get_texts()]


def test_paths_and_views_have_labels_of_their_own(result: RecognitionResult) -> None:
    panel = axes()
    draw_plan(panel, result.last.model.cloud(), result, full_path(result))
    assert labels(panel) == [
        "wall or clutter",
        "true path",
        "path by odometry alone",
        "path of the camera, estimated",
        "base pose (camera beside it), point that it faces",
        "surface normal",
        "not reached",
    ]
    texts = {text.get_text() for text in panel.texts}
    assert {"1", "2", "start"} <= texts


def test_missed_views_are_numbered_and_explained_in_the_legend(result: RecognitionResult) -> None:
    far = [NextView(PlanarPose(-1.2, y, 0.0), (-0.3, 0.0), None, "") for y in (-0.4, 0.0, 0.4, 0.8)]
    panel, run_path = axes(), replace(full_path(result), missed=tuple(far))
    near = [f"an obstacle stands {metres:.2f} m away from there" for metres in (0.2, 0.31)]
    why = (near[0], "blocked on the way", near[1], "blocked on the way")
    draw_plan(panel, result.last.model.cloud(), result, run_path, why)
    legend = labels(panel)[-1]
    assert " ".join(legend.split()) == (
        "not reached: 1, 3 an obstacle stands … m away from there; 2, 4 blocked on the way"
    )
    assert max(map(len, legend.splitlines())) <= LEGEND_WIDTH
    crosses = [text.get_text() for text in panel.texts if text.get_color() == MISSED_COLOUR]
    assert crosses == ["1", "2", "3", "4"]


def test_a_legend_of_many_reasons_is_cut(
    result: RecognitionResult,
) -> None:
    panel, run_path = axes(), full_path(result)
    many = [f"{word} stands in the way of it for a while" for word in "abcdefghijkl"]
    draw_plan(panel, result.last.model.cloud(), result, run_path, many)
    legend = labels(panel)[-1]
    assert legend.count("\n") <= LEGEND_LINES
    assert legend.endswith(" …")


def test_the_plan_of_a_replay_has_no_views(result: RecognitionResult) -> None:
    panel = axes()
    draw_plan(panel, result.last.model.cloud(), result, RunPath())
    assert labels(panel) == ["path of the camera, estimated"]


@pytest.mark.parametrize("inches", [2.5, 6.0])
@pytest.mark.parametrize("beside_deg", [0.0, 60.0, -60.0])
def test_the_start_label_overlaps_no_view_number(
    result: RecognitionResult, inches: float, beside_deg: float
) -> None:
    start = camera_path(result).positions_xyz[0, :2]
    outward = np.arctan2(*start[::-1]) + np.radians(beside_deg)
    stand = start + 0.25 * np.array([np.cos(outward), np.sin(outward)])
    view = NextView(PlanarPose(*stand, 0.0), (0.0, 0.0), None, "on the circle")
    panel = axes(inches)
    draw_plan(panel, result.last.model.cloud(), result, RunPath(views=(view,)))
    panel.figure.canvas.draw()
    boxes = {text.get_text(): text.get_window_extent() for text in panel.texts}
    assert not boxes["start"].overlaps(boxes["1"])


def test_the_plan_contains_all_paths(result: RecognitionResult) -> None:
    panel = axes()
    far = camera_path(result)
    drifted = Trajectory(far.stamps, far.T_map_camera).moved(
        PlanarPose(3.0, -1.0, 0.4).as_transform()
    )
    draw_plan(panel, result.last.model.cloud(), result, RunPath(odometry=drifted))
    (left, right), (low, high) = panel.get_xlim(), panel.get_ylim()
    for places in (far.positions_xyz, drifted.positions_xyz):
        assert ((places[:, 0] > left) & (places[:, 0] < right)).all()
        assert ((places[:, 1] > low) & (places[:, 1] < high)).all()
    assert right - left == pytest.approx(high - low)


def test_the_answer_is_drawn_over_the_distance(result: RecognitionResult) -> None:
    panel = axes()
    draw_probabilities(panel, result, full_path(result))
    assert panel.get_xlabel() == "distance driven [m]"
    assert panel.get_xlim()[1] == pytest.approx(4.5, abs=0.1)
    panel = axes()
    draw_probabilities(panel, result, RunPath())
    assert panel.get_xlabel() == "path of the camera [m]"
    length = np.linalg.norm(np.diff(camera_path(result).positions_xyz, axis=0), axis=1).sum()
    assert panel.get_xlim()[1] == pytest.approx(length, rel=0.02)


def bold(panel) -> list[str]:
    return [text.get_text() for text in panel.texts if text.get_fontweight() == "bold"]


def test_the_bold_curve_is_that_of_the_final_answer(result: RecognitionResult) -> None:
    """Even if another class led in all frames but the last."""
    steps = named(result, True).steps
    close = Prediction.from_probabilities(("night_stand", "chair"), np.array([0.45, 0.55]))
    led = Prediction.from_probabilities(("night_stand", "chair"), np.array([0.99, 0.01]))
    turned = [replace(step, prediction=led) for step in steps[:-1]]
    changed = replace(result, steps=(*turned, replace(steps[-1], prediction=close)))
    panel = axes()
    draw_probabilities(panel, changed, RunPath())
    title, _ = captions(changed, {})
    assert title == "chair or night stand (55 % / 45 %), not confident"
    assert bold(panel) == ["chair 55 %"]


def test_a_run_that_ended_before_its_first_answer_has_a_picture(
    result: RecognitionResult, tmp_path: Path
) -> None:
    unnamed = tuple(replace(step, prediction=None) for step in result.steps)
    early = RecognitionResult(unnamed, interrupted=True)
    assert captions(early, {"truth": "chair"})[0] == "no answer"
    assert captions(early, {})[1].endswith("interrupted")
    draw_run(tmp_path / "early.png", early, {"truth": "chair"})
    assert (tmp_path / "early.png").stat().st_size > 10_000
    panel = axes()
    draw_probabilities(panel, early, RunPath())
    assert "no answer" in {text.get_text() for text in panel.texts}


def test_the_unrolled_grid_is_cropped_to_the_object(result: RecognitionResult) -> None:
    panel, grid = axes(), result.last.grid
    grid.plot(panel)
    heights = result.last.model.cloud().points_xyz[:, 2]
    row = 2 * grid.grid.half_height / grid.grid.shape[2]
    low, high = panel.get_ylim()
    assert heights.min() - (MARGIN_ROWS + 1) * row <= low < heights.min()
    assert heights.max() < high <= heights.max() + (MARGIN_ROWS + 1) * row
    bare = OccupancyGrid(grid.grid, np.zeros_like(grid.states))
    panel = axes()
    bare.plot(panel)
    assert np.ptp(panel.get_ylim()) == pytest.approx(2 * grid.grid.half_height)


def test_unused_frames_are_marked(result: RecognitionResult) -> None:
    panel = axes()
    draw_probabilities(panel, result, RunPath())
    assert any("frame not used" in text.get_text() for text in panel.texts)
    panel = axes()
    draw_probabilities(panel, run(frames(2)), RunPath())
    assert not any("frame not used" in text.get_text() for text in panel.texts)


def test_a_camera_that_stands_still_is_drawn_over_frames(tmp_path: Path) -> None:
    shot = next(frames(1))
    still = run([shot, shot, shot])
    panel = axes()
    draw_probabilities(panel, still, RunPath())
    assert panel.get_xlabel() == "frame"
    draw_run(tmp_path / "still.png", still, {})
    assert (tmp_path / "still.png").stat().st_size > 10_000


def named(
    result: RecognitionResult, known: bool, coverage: float = 1.0, probability: float = 0.55
) -> RecognitionResult:
    """The same run with the longest name."""
    shares = np.array([probability, 1 - probability])
    answer = Prediction.from_probabilities(
        ("night_stand", "chair"), shares, in_distribution=known, coverage=coverage
    )
    steps = (replace(step, prediction=answer, coverage=coverage) for step in result.steps)
    return replace(result, steps=tuple(steps))


def test_a_long_title_ends_before_the_bars(
    result: RecognitionResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    long = "night stand or dresser or monitor (41 % / 33 % / 13 %), not confident, and more"
    monkeypatch.setattr(picture, "captions", lambda *_: (long, ""))
    figure = Figure(figsize=(16, 9.6), dpi=100)
    FigureCanvasAgg(figure)
    shares = {"visible surface modelled": 0.5, "whole surface modelled": 0.3}
    picture._arrange(figure, result, {}, RunPath(), (), shares)
    bars = figure.axes[0]
    left = min(label.get_window_extent().x0 for label in bars.get_yticklabels() + bars.texts)
    heading = next(text for text in figure.texts if text.get_text() == long)
    assert heading.get_window_extent().x1 < left


def test_the_captions_state_confidence_and_correctness(
    result: RecognitionResult,
) -> None:
    title, note = captions(named(result, True, probability=0.91), {"truth": "night_stand"})
    assert title == "night stand (91 %), confident"
    assert note.startswith("correct, ")
    title, note = captions(named(result, True, probability=0.55), {"truth": "night_bath"})
    assert title == "night stand or chair (55 % / 45 %), not confident"
    assert note.startswith("incorrect: the true class is night bath, ")


def test_the_title_names_the_nearest_class_of_an_unknown_object(result: RecognitionResult) -> None:
    title, note = captions(named(result, False), {"truth": "bathtub"})
    assert title == "unknown object (nearest: night stand 55 %), not confident"
    assert note.startswith("the true class is bathtub, ")


def test_the_title_is_not_confident_at_low_coverage(result: RecognitionResult) -> None:
    title, _ = captions(named(result, True, coverage=0.46, probability=0.95), {})
    assert title == "night stand (95 %), not confident"


def test_completeness_is_beside_coverage_and_unknown_without_the_truth() -> None:
    panel = axes()
    draw_shares(panel, {"azimuth covered": 1.0, "surface modelled": 0.873})
    assert [label.get_text() for label in panel.get_yticklabels()] == [
        "azimuth covered", "surface modelled",
    ]  # fmt: skip
    assert [text.get_text() for text in panel.texts] == ["100 %", "87 %"]
    panel = axes()
    draw_shares(panel, {"azimuth covered": 0.46, "surface modelled": None})
    assert [text.get_text() for text in panel.texts] == ["46 %", "unknown without the true shape"]


def test_the_longest_title_fits(
    result: RecognitionResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn, save = [], Figure.savefig

    def kept(figure: Figure, *args, **kwargs) -> None:
        drawn.append(figure)
        save(figure, *args, **kwargs)

    monkeypatch.setattr(Figure, "savefig", kept)
    draw_run(tmp_path / "unknown.png", named(result, False), {"truth": "bathtub"})
    title = drawn[0].texts[0]
    assert title.get_text().startswith("unknown object (nearest: night stand 55 %)")
    assert title.get_window_extent().x1 < drawn[0].bbox.x1
