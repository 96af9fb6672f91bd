"""Cells as boxes, values as colours, the turned object, the panel's text."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification import Classifier
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid
from circumspect.viewer import colouring
from circumspect.viewer.dashboard_state import ObjectSnapshot
from circumspect.viewer.occupied_cells import cell_boxes, outline
from circumspect.viewer.panel_html import (
    answer_html,
    bars_html,
    faults_html,
    legend_html,
    times_html,
)
from circumspect.viewer.probability_picture import (
    FAULT,
    FOOT,
    HEIGHT,
    LEFT,
    MOST_TICKS,
    TOP,
    WIDTH,
    frame_ticks,
    probability_bars,
    probability_picture,
)
from circumspect.viewer.stage import FIELD_OF_VIEW, OBJECT_SHARE, lookout
from circumspect.viewer.turned_object import turned_object

BOUNDS = (
    CylindricalGrid((5, 12, 6), 0.7, 0.9, (1.0, -2.0, 0.5), 0.4),
    RectangularGrid((5, 6, 7), 0.7, (1.0, -2.0, 0.5), 0.3),
)


@pytest.mark.parametrize("bounds", BOUNDS)
@given(seed=st.integers(0, 100))
def test_a_box_lies_in_its_cell(bounds, seed):
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid(bounds, (2 * rng.integers(0, 2, bounds.shape)).astype(np.uint8))
    boxes = cell_boxes(grid)
    middles = boxes.middles_xyz.astype(float) + bounds.centre_xyz
    np.testing.assert_array_equal(bounds.indices(middles), boxes.cells)
    assert len(boxes.cells) == grid.occupied.sum()


@pytest.mark.parametrize("bounds", BOUNDS)
def test_a_mesh_has_a_closed_box_a_cell(bounds):
    states = np.zeros(bounds.shape, np.uint8)
    states[1, 2, 3] = states[4, 5, 0] = 2
    boxes = cell_boxes(OccupancyGrid(bounds, states))
    vertices, faces = boxes.mesh(np.array([True, False]))
    assert vertices.shape == (8, 3)
    both, more = boxes.mesh(np.array([True, True]))
    assert (len(both), len(more), more.max()) == (16, 24, 15)
    a, b, c = vertices[faces.astype(int)].transpose(1, 0, 2)
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
    assert volume == pytest.approx(float(boxes.sizes[0].prod()), rel=1e-4)


@pytest.mark.parametrize("bounds", BOUNDS)
def test_the_outline_is_as_large_as_the_grid(bounds):
    lines = outline(OccupancyGrid(bounds, np.zeros(bounds.shape, np.uint8)))
    reach = np.hypot(lines[..., 0], lines[..., 1]).max()
    if isinstance(bounds, CylindricalGrid):
        assert reach == pytest.approx(bounds.radius, rel=1e-5)
        assert lines[..., 2].max() == pytest.approx(bounds.half_height, rel=1e-5)
    else:
        assert reach == pytest.approx(bounds.half_width * np.sqrt(2), rel=1e-5)


def test_colours_follow_values():
    ramp = colouring.sequential(np.linspace(3.0, 9.0, 5)).astype(int).sum(axis=1)
    assert (np.diff(ramp) > 0).all()
    assert len(np.unique(colouring.sequential(np.full(4, 2.0)), axis=0)) == 1
    red, grey, blue = colouring.signed(np.array([2.0, 0.0, -2.0])).astype(int)
    assert red[0] > red[2]
    assert blue[2] > blue[0]
    assert np.ptp(grey) < 10
    up = colouring.directions(np.array([[0.0, 0.0, 1.0]]))[0]
    assert up.tolist() == [127, 127, 255]


def test_evidence_groups_keep_the_order_and_the_sign():
    values = np.array([-1.0, -0.2, 0.0, 0.4, 1.0])
    groups, colours = colouring.in_groups(values)
    assert (np.diff(groups) > 0).all()
    assert groups[2] == colouring.EVIDENCE_GROUPS // 2
    assert len(colours) == colouring.EVIDENCE_GROUPS
    assert set(colouring.in_groups(np.zeros(3))[0]) == {colouring.EVIDENCE_GROUPS // 2}


def test_a_depth_picture_marks_what_was_not_measured():
    depth = np.array([[np.nan, 1.0], [2.0, 3.0]])
    picture = colouring.depth_picture(depth)
    assert tuple(picture[0, 0]) == colouring.NOTHING_MEASURED
    assert picture[0, 1].astype(int).sum() > picture[1, 1].astype(int).sum()
    assert (colouring.depth_picture(np.full((2, 2), np.nan)) == colouring.NOTHING_MEASURED).all()


@pytest.fixture(scope="module")
def classifier():
    return Classifier.load()


@pytest.fixture(scope="module")
def shown_object(classifier):
    cloud = make_furniture("toilet", 7).sampled(30_000, 0)
    grid = classifier.input_spec.bounds(cloud).hits(cloud.points_xyz)
    zeros = np.zeros((len(cloud), 3))
    return ObjectSnapshot(cloud.points_xyz, zeros, np.ones(len(cloud), int), grid)


class TestTurned:
    def test_a_rotation_by_zero_keeps_the_answer(self, shown_object, classifier):
        turned = turned_object(shown_object, 0.0, classifier)
        np.testing.assert_array_equal(turned.grid.states, shown_object.grid.states)
        assert turned.prediction.label == classifier.classify_grid(shown_object.grid).label

    @pytest.mark.parametrize("yaw_deg", [13.0, 90.0, 217.3])
    def test_a_rotation_changes_the_grid_and_keeps_the_answer(
        self, shown_object, classifier, yaw_deg
    ):
        turned = turned_object(shown_object, np.radians(yaw_deg), classifier)
        assert (turned.grid.states != shown_object.grid.states).any()
        assert turned.grid.grid == shown_object.grid.grid
        assert turned.prediction.label == "toilet"

    def test_an_object_without_a_grid_is_not_rotated(self, classifier):
        assert turned_object(ObjectSnapshot(), 1.0, classifier) is None

    def test_a_classifier_of_other_grids_classifies_the_cloud(self, shown_object, classifier):
        coarse = CylindricalGrid.fit(PointCloud(shown_object.points_xyz), (8, 8, 8)).hits(
            shown_object.points_xyz
        )
        other = ObjectSnapshot(
            shown_object.points_xyz, shown_object.normals_xyz, shown_object.frames_seen, coarse
        )
        assert turned_object(other, 0.5, classifier).prediction.label == "toilet"


def row(**changes):
    values = {
        "frame": 4, "stamp": 2.0, "outcome": "classified", "label": "chair", "probability": 0.9,
        "probabilities": {"chair": 0.9, "sofa": 0.1}, "coverage": 0.5, "points": 1234, "pose_reason": "",
        "milliseconds": {"register": 10.0, "fuse": 5.0},
    }  # fmt: skip
    return values | changes


class TestPanel:
    def test_the_answer_shows_label_truth_and_coverage(self):
        text = answer_html(row(), truth="sofa")
        assert "chair" in text
        assert "incorrect: the true class is sofa" in text
        assert "50 % coverage" in text
        assert "no answer yet" in answer_html({})

    def test_an_answer_that_is_not_confident_shows_the_reason(self):
        few = row(confident=False, reason="at least 75 % coverage is needed")
        assert "not confident: at least 75 % coverage is needed" in answer_html(few)
        assert "not confident" not in answer_html(row(confident=True, reason=""))

    def test_alternatives_and_unknown_objects_are_named(self):
        pair = answer_html(row(alternatives={"table": 0.55, "desk": 0.41}))
        assert "table or desk" in pair
        assert "55 % / 41 %" in pair
        unknown = answer_html(row(in_distribution=False, probability=0.41), truth="chair")
        assert "unknown object" in unknown
        assert "nearest: chair 41 %" in unknown
        assert "correct" not in unknown

    def test_faults_come_with_the_latest_first(self):
        rows = [
            row(frame=i, pose_reason="2 poses are possible" if i in (2, 5) else "")
            for i in range(8)
        ]
        text = faults_html(rows, 8)
        assert text.index("frame 6") < text.index("frame 3")
        assert "frame 6" not in faults_html(rows, 5)
        assert "2 poses are possible" in text
        assert "no fault, all poses reliable" in faults_html(rows, 2)
        many = faults_html([row(frame=i, outcome="no depth") for i in range(50)], 50)
        assert many.count("no depth") == 6

    def test_times_add_up(self):
        assert "15.0 ms" in times_html(row())
        assert "no stage" in times_html({})

    @pytest.mark.parametrize("bad", ["<script>alert(1)</script>", "<img src=x onerror=alert(1)>"])
    def test_text_of_files_is_escaped(self, bad):
        entry = row(
            label=bad, outcome=bad, pose_reason=bad, probabilities={bad: 1.0}, milliseconds={bad: 1.0},
            confident=False, reason=bad, alternatives={bad: 0.5, "b": 0.4},
        )  # fmt: skip
        for text in (
            answer_html(entry, truth=bad, message=bad), bars_html(entry["probabilities"]),
            times_html(entry), faults_html([entry], 1),
        ):  # fmt: skip
            assert "<script" not in text
            assert "<img" not in text
            assert "&lt;" in text

    def test_history_is_a_column_a_frame(self):
        rows = [row() for _ in range(30)] + [row(outcome="no depth in the frame", pose_reason=None)]
        picture = probability_bars(rows, 31, 31)
        assert picture.shape[1] == WIDTH
        assert tuple(picture[-1, -1]) == FAULT
        assert tuple(picture[-1, 0]) != FAULT
        chair = (picture[:HEIGHT, 0] == colouring.CLASSES[0]).all(axis=1).mean()
        assert chair == pytest.approx(0.9, abs=0.02)

    def test_a_long_history_still_fits(self):
        rows = [row() for _ in range(5000)]
        assert probability_picture(rows, 5000).shape == probability_picture(rows, 0).shape

    def test_history_has_axes_around_its_bars(self):
        rows = [row() for _ in range(30)]
        picture = probability_picture(rows, 30)
        bars = picture[TOP : TOP + HEIGHT + FOOT, LEFT : LEFT + WIDTH]
        np.testing.assert_array_equal(bars, probability_bars(rows, 30, 30))
        for axis in (picture[:, :LEFT], picture[TOP + HEIGHT + FOOT :]):
            assert (axis < 128).all(axis=2).sum() > 30, "nothing is written there"

    @pytest.mark.parametrize(("frames", "ticks"), [(20, [5, 10, 15, 20]), (149, [50, 100])])
    def test_frames_are_counted_in_round_numbers(self, frames, ticks):
        assert frame_ticks(frames) == ticks

    @given(frames=st.integers(1, 10**7))
    def test_axis_has_few_ticks(self, frames):
        assert len(frame_ticks(frames)) <= MOST_TICKS

    def test_legend_explains_lines_and_frustum_in_their_colours(self):
        legend = legend_html()
        for words in ("path of the camera", "odometry", "camera, what it sees", "next view"):
            assert words in legend
        for colour in (colouring.PATH, colouring.ODOMETRY, colouring.TARGET):
            assert f"rgb({','.join(map(str, colour))})" in legend


@given(
    reach=st.floats(0.05, 5.0), azimuth=st.floats(-3.1, 3.1), x=st.floats(-9.0, 9.0),
    wide=st.floats(1.2, 2.4),
)  # fmt: skip
def test_object_fills_the_view_beside_the_panel(reach, azimuth, x, wide):
    middle = np.array([x, 1.0, 0.5])
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    eye, look_at = lookout(middle, reach, level)
    forward = (look_at - eye) / np.linalg.norm(look_at - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    half = np.linalg.norm(look_at - eye) * np.tan(FIELD_OF_VIEW / 2)
    assert reach / half == pytest.approx(OBJECT_SHARE)
    assert np.dot(forward, level) < 0, "the view is from the wrong side"
    across = np.dot(middle - eye, right) / half
    assert across < 0, "the panel on the right would hide it"
    assert across - OBJECT_SHARE > -wide, "it leaves the view on the left"
