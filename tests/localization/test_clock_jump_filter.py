"""Which stamps of ceiling cameras are accepted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.localization import CeilingImage
from circumspect.localization.intelligent_space import (
    MAX_JUMP_S,
    MIN_CONFIRMATIONS,
    ClockJumpFilter,
)

GREY = np.zeros((2, 2), np.uint8)


def images(stamp, *cameras):
    return [CeilingImage(camera, stamp, GREY) for camera in cameras or "a"]


@given(st.lists(st.floats(0.01, MAX_JUMP_S - 0.01), min_size=1, max_size=20))
def test_closely_following_images_are_accepted(gaps):
    guard, after = ClockJumpFilter("a"), -np.inf
    for stamp in np.cumsum(gaps):
        assert guard.update(images(stamp), after) >= stamp
        after = stamp


@given(st.floats(MAX_JUMP_S + 0.01, 1e6), st.integers(MIN_CONFIRMATIONS + 1, 20))
def test_a_regular_spacing_of_any_length_is_learnt(spacing, count):
    """The first images wait and are accepted together; the later ones do not wait."""
    guard, after = ClockJumpFilter("a"), 0.0
    for n in range(1, count):
        until = guard.update(images(spacing * n), after)
        assert (until >= spacing * n) == (n >= MIN_CONFIRMATIONS)
        if until >= spacing * n:
            after = spacing * n


def test_a_jump_of_all_cameras_is_accepted():
    assert ClockJumpFilter("ab").update(images(500.0, "a", "b"), 0.0) == 500.0
    assert ClockJumpFilter("ab").update(images(500.0, "a"), 0.0) == MAX_JUMP_S
    assert ClockJumpFilter("a").update(images(500.0, "a"), 0.0) == MAX_JUMP_S
    assert ClockJumpFilter("abc").update(images(500.0, "a", "b"), 0.0) == MAX_JUMP_S


def test_later_images_with_earlier_stamps_refute_a_jump():
    guard = ClockJumpFilter("a")
    assert [guard.update(images(stamp), 0.0) for stamp in (5000.0, 100.0, 100.1)] == [
        MAX_JUMP_S
    ] * 3
    assert guard.update(images(100.2), 0.0) == 100.2
    # One pause does not make every clock jump a pause.
    assert guard.update(images(5000.0), 100.2) == pytest.approx(100.2 + MAX_JUMP_S)


def test_at_the_end_a_second_image_confirms():
    guard = ClockJumpFilter("a")
    guard.update(images(0.0), -5.0)
    guard.update(images(15.0), 0.0)
    assert guard.final_limit(0.0) == MAX_JUMP_S
    guard.update(images(30.0), 0.0)
    assert guard.final_limit(0.0) == 30.0


@pytest.mark.parametrize("cameras", ["a", "abc"])
def test_two_photographs_far_apart_are_no_clock_jump(cameras):
    """No two images were close enough in time to reveal a clock jump."""
    guard = ClockJumpFilter(cameras)
    guard.update(images(0.0), -np.inf)
    assert guard.update(images(15.0), 0.0) == MAX_JUMP_S
    assert guard.final_limit(0.0) == 15.0
