from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.planning import Answer, Conviction

RULE = Conviction(probability=0.8, seen=0.5, over=0.2, change=0.1)


def reached(values, shares, unknown=()) -> str | None:
    told = [{"chair": float(p), "sofa": 1 - float(p)} for p in values]
    pairs = enumerate(zip(told, shares, strict=True))
    return RULE.reached([Answer(p, float(seen), i not in unknown) for i, (p, seen) in pairs])


def test_sure_for_long_enough() -> None:
    assert "chair" in str(reached(np.full(11, 0.9), np.linspace(0.3, 0.7, 11)))


@pytest.mark.parametrize(
    ("values", "shares"),
    [
        ([], []),
        (np.full(11, 0.9), np.linspace(0.1, 0.45, 11)),  # too little seen
        (np.full(11, 0.7), np.linspace(0.3, 0.7, 11)),  # not probable enough
        (np.linspace(0.75, 0.9, 11), np.linspace(0.5, 0.7, 11)),  # still rising
        (np.full(11, 0.9), np.linspace(0.55, 0.7, 11)),  # not for long enough
        ([0.9] * 5 + [0.2] + [0.9] * 5, np.linspace(0.3, 0.7, 11)),  # another one led
    ],
)
def test_not_yet(values, shares) -> None:
    assert reached(values, shares) is None


def test_who_did_not_lead_all_the_time_is_not_sure_however_much_may_change() -> None:
    values, shares = [0.9] * 5 + [0.4] + [0.9] * 5, np.linspace(0.3, 0.7, 11)
    told = [
        Answer({"chair": p, "sofa": 1 - p}, float(seen), True)
        for p, seen in zip(values, shares, strict=True)
    ]
    rule = replace(RULE, change=0.9)
    assert rule.reached(told) is None
    assert rule.reached([replace(a, probabilities={"chair": 0.9, "sofa": 0.1}) for a in told])


@pytest.mark.parametrize(("unknown", "sure"), [([0, 4], True), ([7], False), ([10], False)])
def test_an_object_like_none_of_the_classes_is_nothing_to_be_sure_of(unknown, sure) -> None:
    """Before the window it may have looked like nothing known."""
    told = reached(np.full(11, 0.9), np.linspace(0.3, 0.7, 11), unknown)
    assert (told is not None) == sure


@given(st.lists(st.floats(0.5, 1.0), min_size=2, max_size=30))
def test_what_convinces_never_changed_by_more_than_allowed(values) -> None:
    shares = np.linspace(0.25, 1.0, len(values))
    if reached(values, shares) is not None:
        last = [v for v, s in zip(values, shares, strict=True) if s > shares[-1] - RULE.over]
        assert max(abs(v - values[-1]) for v in last) <= RULE.change
        assert values[-1] >= RULE.probability
