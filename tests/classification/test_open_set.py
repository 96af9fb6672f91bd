"""The open-set decision from probability and distance."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification.open_set import OpenSetRule
from circumspect.errors import InputError

RULE = OpenSetRule(bias=1.0, other=-1.0, distance=-2.0, threshold=0.4)


@given(a=st.floats(0, 1), b=st.floats(0, 1), distance=st.floats(0, 2))
def test_a_higher_other_probability_never_raises_the_familiarity(a, b, distance):
    low, high = sorted((a, b))
    first, second = RULE.probability([low, high], [distance, distance])
    assert 0 <= second <= first <= 1


def test_without_a_distance_the_probability_decides():
    found = RULE.probability([0.01, 0.99])
    assert found[0] > 0.9 > found[1]


def test_a_rule_round_trips_through_json():
    assert OpenSetRule.from_dict(json.loads(json.dumps(RULE.to_dict()))) == RULE


@pytest.mark.parametrize(
    "changes",
    [
        {"bias": np.inf}, {"other": None}, {"distance": "1"}, {"threshold": 1.5},
        {"threshold": True}, {"more": 1},
    ],
)  # fmt: skip
def test_broken_rules_are_refused(changes):
    with pytest.raises(InputError):
        OpenSetRule.from_dict({**RULE.to_dict(), **changes})


@pytest.mark.parametrize("document", [None, [], "rule", {"bias": 1.0}])
def test_documents_that_are_no_rule_are_refused(document):
    with pytest.raises(InputError):
        OpenSetRule.from_dict(document)
