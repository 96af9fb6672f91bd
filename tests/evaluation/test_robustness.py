"""Accuracy on corrupted clouds."""

import numpy as np
import pytest
from two_kinds import ByHeight, flat_and_tall

from circumspect.datasets.corruption import CORRUPTIONS
from circumspect.errors import InputError, WeightsError
from circumspect.evaluation.robustness import CLEAN, measure_robustness


def test_every_corruption_is_measured_and_clear_shapes_survive_most():
    passes = []
    found = measure_robustness(
        ByHeight(), flat_and_tall(20), progress=lambda *reported: passes.append(reported)
    )
    assert found.clean == 1.0
    assert list(found.accuracy) == list(CORRUPTIONS)
    assert [done for done, _ in passes] == sorted(done for done, _ in passes)
    assert passes[-1] == (61, 61)
    assert found.accuracy["jitter"].tolist() == [1.0] * 5
    assert found.accuracy["tilt"].min() > 0.9
    document = found.to_dict()
    assert document["mean"] == pytest.approx(np.mean(list(document["accuracy"].values())))


def test_a_constant_predictor_is_correct_half_of_the_time():
    class Stubborn(ByHeight):
        def probabilities(self, inputs, contexts=None):
            return np.tile([0.9, 0.1], (len(inputs), 1))

    assert measure_robustness(Stubborn(), flat_and_tall(8)).mean == 0.5


def test_weights_for_other_classes_are_refused():
    class Other(ByHeight):
        classes = ("a", "b")

    with pytest.raises(WeightsError, match="same classes"):
        measure_robustness(Other(), flat_and_tall(2))


def test_an_empty_set_is_refused():
    objects = flat_and_tall(2)
    with pytest.raises(InputError, match="nothing to evaluate"):
        measure_robustness(ByHeight(), objects.subset(np.zeros(len(objects), bool)))


def test_an_object_without_a_shape_is_no_wrong_answer():
    objects = flat_and_tall(4)
    objects.points_xyz[1] = 0.25
    with pytest.raises(InputError, match=f"{objects.names[1]}: all .* points lie in one place"):
        measure_robustness(ByHeight(), objects)


def test_finished_measurements_are_not_repeated():
    kept = {}

    def keep(kind, measure):
        return kept[kind] if kind in kept else kept.setdefault(kind, measure())

    class Tired(ByHeight):
        def probabilities(self, inputs, contexts=None):
            raise AssertionError("asked again")

    objects = flat_and_tall(6)
    found = measure_robustness(ByHeight(), objects, keep=keep)
    assert list(kept) == [CLEAN, *CORRUPTIONS]
    passes = []
    again = measure_robustness(
        Tired(), objects, keep=keep, progress=lambda *reported: passes.append(reported)
    )
    assert again.to_dict() == found.to_dict()
    assert passes[-1] == (61, 61)
