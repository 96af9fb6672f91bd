"""Rooms are evaluated with a calibration that leaves them out."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.left_out_rooms import measured, page_text

from circumspect.classification import Classifier
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.evaluation.classifier_calibration import Answers

CLASSIFIER = Classifier.load("robot")


def drawn(count, seed, correct=True):
    """Probable answers to known objects, correct or not, and improbable ones to other objects."""
    rng = np.random.default_rng(seed)
    classes = np.array(CLASSIFIER.classes)
    label = rng.integers(len(classes), size=count)
    other = rng.random(count) < 0.3
    named = label if correct else (label + 1) % len(classes)
    scores = np.where(other, rng.uniform(0.3, 0.6, count), rng.uniform(0.8, 0.99, count))
    # Some wrong answers: fitting a temperature needs both kinds.
    named = np.where(rng.random(count) < 0.1, (label + 1) % len(classes), named)
    scores = np.where(named == label, scores, np.minimum(scores, 0.6)) if correct else scores
    probabilities = np.repeat((1 - scores)[:, None] / (len(classes) - 1), len(classes), axis=1)
    probabilities[np.arange(count), named] = scores
    return Answers(
        probabilities,
        np.where(other, rng.uniform(0.5, 0.9, count), rng.uniform(0.01, 0.3, count)),
        np.where(other, rng.uniform(0.1, 0.3, count), rng.uniform(0.01, 0.1, count)),
        np.where(other, OTHER, classes[label]).astype(np.str_),
        np.full(count, 0.5),
    )


def figures(real):
    sources = np.array(["a", "b"])[np.arange(len(real.labels)) % 2]
    rooms = np.array(["a/1", "b/1", "a/2", "b/2"])[np.arange(len(real.labels)) % 4]
    return measured(CLASSIFIER, drawn(400, 0), drawn(400, 1), real, sources, rooms)


def test_real_objects_like_the_simulated_ones_are_answered_with_confidence():
    found = figures(drawn(100, 2))
    assert found["rooms"] == 4
    assert found["known"] + found["other"] == 100
    assert found["confident"] > 0.6 * found["known"]
    assert found["correct_confident"] == found["confident"]
    assert found["confident_other"] == 0
    assert found["open_set"] == pytest.approx(1.0)
    assert "4" in page_text(found)


def test_a_room_does_not_choose_its_own_bound():
    """Probable but wrong answers of one room are confident by the bound of the others."""
    good, bad = drawn(75, 3), drawn(25, 4, correct=False)
    real = Answers.joined([good, bad])
    rooms = np.array(["good"] * 75 + ["bad"] * 25)
    found = measured(CLASSIFIER, drawn(400, 0), drawn(400, 1), real, rooms, rooms)
    assert found["confident"] - found["correct_confident"] >= 10
