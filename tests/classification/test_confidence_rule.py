"""Bounds that make an answer confident."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.errors import InputError

RULE = ConfidenceRule((0.2, 0.5, 0.75), (0.97, 0.9, 0.8), 0.95)


@pytest.mark.parametrize(
    ("coverage", "bound"),
    [(None, 0.95), (0.1, None), (0.2, 0.97), (0.49, 0.97), (0.5, 0.9), (1.0, 0.8)],
)
def test_the_last_bound_reached_applies(coverage, bound):
    assert RULE.bound(coverage) == bound


@given(probability=st.floats(0, 1), coverage=st.none() | st.floats(0, 1))
def test_an_answer_has_a_reason_exactly_where_it_is_not_confident(probability, coverage):
    bound = RULE.bound(coverage)
    confident = bound is not None and probability >= bound
    assert confident == (not RULE.reason(probability, coverage))


def test_reasons_name_the_unmet_bound():
    assert RULE.reason(1.0, 0.1) == "at least 20 % coverage is needed"
    assert RULE.reason(0.5, 0.6) == "a probability of at least 90 % is needed"
    assert ConfidenceRule((0.0,), (1.5,)).reason(1.0, 0.5) == "more coverage is needed"


def test_a_bound_just_above_the_probability_is_shown_apart_from_it():
    rule = ConfidenceRule((0.0,), (0.9357,), 0.9)
    assert (
        rule.reason(0.9354, 0.4) == "a probability of at least 93.57 % instead of 93.54 % is needed"
    )
    nearly = rule.reason(0.93569, 0.4)
    assert nearly == "a probability of at least 93.57 % instead of 93.56 % is needed"
    assert rule.reason(0.91, 0.4) == "a probability of at least 94 % is needed"


def test_a_rule_round_trips_through_json():
    assert ConfidenceRule.from_dict(json.loads(json.dumps(RULE.to_dict()))) == RULE
    assert ConfidenceRule.from_dict(None) == ConfidenceRule()


@pytest.mark.parametrize(
    "document",
    [
        {},
        [],
        "0.9",
        {"coverage": [0.5], "probability": [0.9]},
        {"coverage": 0.5, "probability": [0.9], "without_coverage": 0.9},
        {"coverage": [0.5, 0.4], "probability": [0.9, 0.9], "without_coverage": 0.9},
        {"coverage": [0.5], "probability": [0.9, 0.8], "without_coverage": 0.9},
        {"coverage": [0.5], "probability": ["0.9"], "without_coverage": 0.9},
        {"coverage": [0.5], "probability": [float("nan")], "without_coverage": 0.9},
        {"coverage": [0.5], "probability": [True], "without_coverage": 0.9},
        {"coverage": [], "probability": [], "without_coverage": 0.9},
        {"coverage": [i / 1e4 for i in range(9999)], "probability": [0.9], "without_coverage": 1},
    ],
)
def test_broken_rules_are_refused(document):
    with pytest.raises(InputError):
        ConfidenceRule.from_dict(document)
