"""Which pose of an object of unknown vertical counts, and when its answer is confident."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from circumspect.classification import Classifier, Prediction
from circumspect.classification.upright import (
    CLOSE,
    WayUp,
    best_answer,
    classify_any_way_up,
    ranked,
    stood,
    without_floor,
)
from circumspect.geometry import PointCloud

LYING = Rotation.from_euler("x", 90, degrees=True)


def way_up(label: str, score: float, upright: bool = False, known: bool = True) -> WayUp:
    probabilities = {label: score, "lamp": 1.0 - score}
    prediction = Prediction(label, score, probabilities, in_distribution=known)
    return WayUp(prediction, Rotation.identity() if upright else LYING, upright)


@given(
    st.lists(st.tuples(st.floats(0.01, 1.0), st.booleans()), min_size=1, max_size=8),
    st.floats(0.0, 1.0),
)
def test_the_pose_of_the_file_goes_first_where_it_is_close(others, close):
    ways = [
        way_up("chair", score, number == 0, known) for number, (score, known) in enumerate(others)
    ]
    order = ranked(ways, close)
    assert sorted(map(id, order)) == sorted(map(id, ways))
    best = max(ways, key=lambda one: (one.prediction.in_distribution, one.score))
    if order[0].upright and best is not ways[0]:
        assert ways[0].prediction.in_distribution
        assert ways[0].score >= close * best.score
    else:
        assert order[0].score == best.score
    known = [one.prediction.in_distribution for one in order]
    assert known == sorted(known, reverse=True)


@pytest.mark.parametrize(("score", "confident"), [(0.8, True), (0.97, False)])
def test_a_close_pose_with_another_label_removes_the_confidence(score, confident):
    ways = [way_up("chair", 0.98, upright=True), way_up("bed", score)]
    prediction, pose = best_answer(ways, None)
    assert (prediction.label, prediction.confident) == ("chair", confident)
    assert pose == ways[0].pose
    if not confident:
        assert prediction.reason == "in another pose it is a bed (97 %)"


def test_a_close_pose_with_the_same_label_keeps_the_confidence():
    ways = [way_up("chair", 0.98, upright=True), way_up("chair", 0.97)]
    assert best_answer(ways, None)[0].confident


@pytest.mark.parametrize(
    ("floorless", "reason"),
    [
        (way_up("bed", 0.97), "without what may be a floor it is a bed (97 %)"),
        (way_up("table", 0.97), ""),
        (way_up("bed", 0.5), ""),
        (way_up("bed", 0.97, known=False), ""),
    ],
)
def test_a_confident_answer_of_the_file_s_pose_is_kept_unless_the_floorless_object_differs(
    floorless, reason
):
    prediction, _ = best_answer([way_up("table", 0.99, upright=True)], floorless)
    assert (prediction.label, prediction.in_distribution) == ("table", True)
    assert prediction.reason == reason


@pytest.mark.parametrize("upright", [True, False])
def test_no_other_answer_to_a_cloud_with_a_floor_is_in_distribution(upright):
    ways = [way_up("table", 0.6, upright=upright)]
    if not upright:
        ways = [way_up("chair", 0.3, upright=True), way_up("table", 0.99)]
    prediction, _ = best_answer(ways, way_up("table", 0.97))
    assert not prediction.in_distribution


def test_without_a_bound_the_most_probable_pose_wins():
    ways = [way_up("chair", 0.95, upright=True), way_up("bed", 0.96)]
    assert ranked(ways, 1.0)[0].prediction.label == "bed"
    assert ranked(ways, CLOSE)[0].prediction.label == "chair"


def test_a_scan_on_its_head_is_no_table(scanned_chair):
    """A floor above an object looks like a table."""
    classifier = Classifier.load(threads=1)
    prediction, _ = classify_any_way_up(classifier, scanned_chair, metric=True)
    assert not prediction.confident
    floorless = without_floor(classifier, scanned_chair, metric=True)
    assert floorless is not None
    assert (floorless.prediction.label, floorless.upright) == ("chair", False)
    assert floorless.pose.apply([0.0, 0.0, -1.0]) == pytest.approx([0.0, 0.0, 1.0], abs=0.05)


def test_no_floor_is_no_answer():
    ball = np.random.default_rng(0).normal(size=(3000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    assert without_floor(Classifier.load(threads=1), PointCloud(ball)) is None


@pytest.fixture
def scanned_chair() -> PointCloud:
    from scanned_floor import on_floor

    return stood(
        PointCloud(on_floor("chair", points=6000)[0]), Rotation.from_euler("x", 180, degrees=True)
    )
