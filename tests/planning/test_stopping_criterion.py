from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.planning import Answer, StoppingCriterion


def answers(*letters: str) -> list[Answer]:
    """A capital letter is a confident answer."""
    return [
        Answer({name: 0.9 if name == one.lower() else 0.1 for name in "ab"}, 0.8, True, one < "a")
        for one in letters
    ]


def test_three_confident_answers_of_one_label_are_final() -> None:
    reason = StoppingCriterion().reached(answers("b", "A", "A", "A"))
    assert reason == "the answer is confident: a in 3 consecutive frames"


@pytest.mark.parametrize(
    "letters", ["", "A", "AA", "AAa", "aAA", "AaA", "ABA", "BAA", "AAAAa", "AAAAB", "aaaaaa"]
)
def test_fewer_changing_or_not_confident_answers_are_not_final(letters: str) -> None:
    assert StoppingCriterion().reached(answers(*letters)) is None


@given(st.text("abAB", max_size=12), st.integers(1, 5))
def test_answers_are_final_if_the_last_ones_agree_and_are_confident(
    letters: str, frames: int
) -> None:
    last = letters[-frames:]
    final = last in ("A" * frames, "B" * frames)
    assert (StoppingCriterion(frames).reached(answers(*letters)) is not None) == final


@pytest.mark.parametrize("frames", [0, -1])
def test_a_criterion_of_zero_frames_is_refused(frames: int) -> None:
    with pytest.raises(InputError, match="at least 1 frame"):
        StoppingCriterion(frames)
