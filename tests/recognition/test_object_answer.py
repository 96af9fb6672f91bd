"""Answers after every frame: how many grids are classified, and where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from box_world import box_shots, fused
from volume_classifier import VolumeClassifier

from circumspect.classification import GridSpec, Prediction
from circumspect.grid import CylindricalGrid, OccupancyGrid
from circumspect.recognition.object_answer import STABLE_ANSWERS, ObjectAnswer
from circumspect.recognition.object_grids import MAX_SHIFT_CELLS, ObjectGrids
from circumspect.reconstruction import ObjectModel


class Scripted(VolumeClassifier):
    """Three views; the answer follows a script by the number of views."""

    def __init__(self, one: str = "full", several: str = "full") -> None:
        super().__init__()
        self.answers = {1: one, 3: several}
        self.asked: list[int] = []

    @property
    def input_spec(self) -> GridSpec:
        return replace(
            super().input_spec, azimuth_views=3, dithered=True, margin=1.5, visibility=True
        )

    def classify_grid(self, *views: OccupancyGrid, **options) -> Prediction:
        self.asked.append(len(views))
        full = self.answers[len(views)] == "full"
        shares = np.array([0.1, 0.9] if full else [0.9, 0.1])
        return Prediction.from_probabilities(self.classes, shares, rule=self.rule)


@pytest.fixture(scope="module")
def models() -> list[ObjectModel]:
    found = [fused(box_shots(6))]
    for frame, mask in box_shots(9):
        found.append(found[-1].fused(frame, mask, frame.pose))
    return found


def follow(answer: ObjectAnswer, models: list[ObjectModel]) -> None:
    for model in models:
        assert answer.grid(model) is None
        answer.classify(model)


def test_a_stable_answer_is_confirmed_by_one_grid(models: list[ObjectModel]) -> None:
    classifier = Scripted()
    answer = ObjectAnswer(classifier)
    follow(answer, models[:8])
    assert classifier.asked == [3] * STABLE_ANSWERS + [1] * (8 - STABLE_ANSWERS)
    answer.finalise(models[7])
    assert classifier.asked[-1] == 3
    assert not answer.is_provisional


def test_one_grid_never_changes_an_answer(models: list[ObjectModel]) -> None:
    classifier = Scripted(one="empty")
    answer = ObjectAnswer(classifier)
    follow(answer, models[:7])
    assert classifier.asked == [3, 3, 3, 1, 3, 3, 3, 1, 3]
    assert answer.prediction is not None
    assert answer.prediction.label == "full"


def test_a_changing_answer_uses_all_grids_until_it_is_stable(
    models: list[ObjectModel],
) -> None:
    classifier = Scripted()
    answer = ObjectAnswer(classifier)
    follow(answer, models[:4])
    classifier.answers = {1: "empty", 3: "empty"}
    follow(answer, models[4:8])
    assert classifier.asked == [3, 3, 3, 1, 1, 3, 3, 3, 1]


def test_grids_are_kept_while_they_contain_the_object(models: list[ObjectModel]) -> None:
    grids = ObjectGrids(Scripted())
    places = []
    for model in models:
        assert grids.update(model, 3) is None
        first = grids.first
        assert first is not None
        fitted = Scripted().input_spec.bounds(model.cloud())
        assert isinstance(first.grid, CylindricalGrid)
        apart = np.subtract(first.grid.centre_xyz, fitted.centre_xyz)
        assert np.hypot(*apart[:2]) <= MAX_SHIFT_CELLS * fitted.radius / 16 + 1e-12
        # Occupied where the surface is, in spite of the older fit.
        np.testing.assert_array_equal(first.occupied, first.grid.hits(model.cloud()).occupied)
        places.append(first.grid)
    assert len(set(places)) < len(places)
    grids.finalise(models[-1])
    assert grids.first is not None
    assert grids.first.grid == Scripted().input_spec.bounds(models[-1].cloud())


def test_without_a_margin_grids_are_refitted_to_a_growing_object(models: list[ObjectModel]) -> None:
    class Tight(Scripted):
        @property
        def input_spec(self) -> GridSpec:
            return replace(super().input_spec, azimuth_views=1, dithered=False, margin=1.0)

    grids = ObjectGrids(Tight())
    for model in models:
        grids.update(model, 1)
        points = model.cloud().points_xyz
        assert grids.first is not None
        inside = grids.first.grid.indices(points)[:, 0] >= 0
        assert inside.all()
