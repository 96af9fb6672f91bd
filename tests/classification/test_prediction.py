"""Predictions are pickled, converted to JSON and compared."""

from __future__ import annotations

import copy
import dataclasses
import json
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from circumspect.classification import Prediction

ANSWER = Prediction.from_probabilities(
    ("bed", "chair"), np.array([0.02, 0.98], np.float32), {"grid": 1.23456}, distance=0.1
)


def passed_on(prediction: Prediction) -> Prediction:
    return prediction


@pytest.mark.parametrize(
    "travel",
    [
        *(lambda p, n=n: pickle.loads(pickle.dumps(p, n)) for n in range(2, 6)),
        copy.copy,
        copy.deepcopy,
    ],
)
def test_copies_are_equal_and_as_read_only(travel):
    copied = travel(ANSWER)
    assert copied == ANSWER
    assert list(copied.probabilities) == ["bed", "chair"]
    assert copied.milliseconds == ANSWER.milliseconds
    with pytest.raises(TypeError, match="read-only"):
        copied.probabilities["bed"] = 1.0


def test_a_prediction_is_pickled_between_processes():
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert pool.submit(passed_on, ANSWER).result() == ANSWER


def test_equality_ignores_the_time():
    later = dataclasses.replace(ANSWER, milliseconds={"grid": 9.0})
    assert later == ANSWER
    assert len({later, ANSWER}) == 1
    assert dataclasses.replace(ANSWER, in_distribution=False) != ANSWER


def test_numbers_given_as_a_dict_are_not_shared():
    numbers = {"chair": 1.0}
    prediction = Prediction("chair", 1.0, numbers)
    numbers["chair"] = 0.0
    assert prediction.probabilities == {"chair": 1.0}


@pytest.mark.parametrize(
    "write",
    [
        lambda table: table.update(bed=1.0),
        lambda table: table.pop("bed"),
        lambda table: table.popitem(),
        lambda table: table.clear(),
        lambda table: table.setdefault("sofa", 1.0),
        lambda table: table.__delitem__("bed"),
        lambda table: table.__ior__({"bed": 1.0}),
    ],
)
def test_probabilities_are_read_only(write):
    with pytest.raises(TypeError, match="read-only"):
        write(ANSWER.probabilities)
    assert list(ANSWER.probabilities) == ["bed", "chair"]


def test_json_and_plain_dicts():
    reported = json.loads(json.dumps(ANSWER.to_dict()))
    assert reported == {
        "label": "chair",
        "confident": True,
        "reason": "",
        "in_distribution": True,
        "in_distribution_probability": None,
        "distance": 0.1,
        "coverage": None,
        "probability": pytest.approx(0.98),
        "probabilities": {"bed": pytest.approx(0.02), "chair": pytest.approx(0.98)},
        "alternatives": {},
        "milliseconds": {"grid": 1.235},
    }
    assert json.loads(json.dumps(ANSWER.probabilities)) == reported["probabilities"]
    assert dataclasses.asdict(ANSWER)["probabilities"] == ANSWER.probabilities


def test_numpy_numbers_are_accepted():
    reported = Prediction("a", np.float32(0.5), {"a": np.float32(0.5)}, {"grid": np.float64(1)})
    assert json.loads(json.dumps(reported.to_dict()))["probabilities"] == {"a": 0.5}


def test_repr_names_label_probability_and_confidence():
    assert repr(ANSWER) == "Prediction(chair 0.98, confident)"
    unknown = dataclasses.replace(ANSWER, in_distribution=False)
    assert repr(unknown) == "Prediction(chair 0.98, unknown object)"


@pytest.mark.parametrize(
    ("shares", "options", "text", "reason"),
    [
        ([0.02, 0.98, 0.0], {}, "chair (98 %)", ""),
        ([0.02, 0.98, 0.0], {"coverage": 0.75}, "chair (98 %)", ""),
        (
            [0.02, 0.98, 0.0], {"coverage": 0.74}, "chair (98 %)",
            "at least 75 % coverage is needed",
        ),
        (
            [0.41, 0.55, 0.04], {"coverage": 1.0}, "chair or bed (55 % / 41 %)",
            "a probability of at least 90 % is needed",
        ),
        (
            [0.3, 0.41, 0.29], {"in_distribution": False}, "unknown object (nearest: chair 41 %)",
            "the object is unlike the trained classes",
        ),
    ],
)  # fmt: skip
def test_an_answer_is_confident_if_known_probable_and_seen_enough(shares, options, text, reason):
    answer = Prediction.from_probabilities(("bed", "chair", "sofa"), np.array(shares), **options)
    assert (answer.text, answer.reason, answer.confident) == (text, reason, not reason)


def test_classes_that_share_the_probability_are_alternatives():
    names = tuple("abcdefghij")
    pair = Prediction.from_probabilities(names, np.array([0.55, 0.41, *[0.005] * 8]))
    assert dict(pair.alternatives) == {"a": 0.55, "b": 0.41}
    assert pair.to_dict()["alternatives"] == {"a": 0.55, "b": 0.41}
    scattered = Prediction.from_probabilities(names, np.full(10, 0.1))
    assert not scattered.alternatives
    alone = Prediction.from_probabilities(names, np.array([0.91, *[0.01] * 9]))
    assert not alone.alternatives
    assert not dataclasses.replace(pair, in_distribution=False).alternatives


def test_a_class_of_hardly_any_probability_is_no_alternative():
    shares = np.array([0.85, 0.04, 0.04, 0.07])
    assert Prediction.from_probabilities(("a", "b", "c", "d"), shares).alternatives == {}
    shares = np.array([0.55, 0.32, 0.08, 0.05])
    found = Prediction.from_probabilities(("a", "b", "c", "d"), shares).alternatives
    assert list(found) == ["a", "b"]
