"""Accuracy on corrupted clouds."""

import numpy as np
import pytest

from circumspect.classification import GridRecipe
from circumspect.datasets import ObjectSet
from circumspect.datasets.corruption import CORRUPTIONS
from circumspect.errors import WeightsError
from circumspect.evaluation.robustness import measure_robustness

CLASSES = ("flat", "tall")


class ByHeight:
    """Tall objects fill more rows of the grid than flat ones."""

    classes = CLASSES
    recipe = GridRecipe()

    def probabilities(self, inputs):
        tall = inputs.any(axis=(1, 2, 3, 4)).mean(axis=1)
        return np.stack([1 - tall, tall], axis=1)


def objects(count=20):
    rng = np.random.default_rng(0)
    labels = np.arange(count) % 2
    size = np.where(labels[:, None, None] == 0, [2.0, 0.3, 0.1], [0.3, 0.2, 2.0])
    points = (rng.random((count, 300, 3)) - 0.5) * size
    names = np.array([f"{CLASSES[k]}_{i:04d}" for i, k in enumerate(labels)])
    return ObjectSet(points.astype(np.float32), labels.astype(np.int64), names, CLASSES)


def test_every_corruption_is_measured_and_clear_shapes_survive_most():
    passes = []
    found = measure_robustness(ByHeight(), objects(), progress=lambda *told: passes.append(told))
    assert found.clean == 1.0
    assert list(found.accuracy) == list(CORRUPTIONS)
    assert passes[-1] == (60, 60)
    assert found.accuracy["jitter"].tolist() == [1.0] * 5
    assert found.accuracy["tilt"].min() > 0.9
    document = found.to_dict()
    assert document["mean"] == pytest.approx(np.mean(list(document["accuracy"].values())))


def test_a_predictor_that_always_says_the_same_is_right_half_of_the_time():
    class Stubborn(ByHeight):
        def probabilities(self, inputs):
            return np.tile([0.9, 0.1], (len(inputs), 1))

    assert measure_robustness(Stubborn(), objects(8)).mean == 0.5


def test_weights_for_other_classes_are_refused():
    class Other(ByHeight):
        classes = ("a", "b")

    with pytest.raises(WeightsError, match="same classes"):
        measure_robustness(Other(), objects(2))
