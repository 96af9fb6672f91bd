"""Which stamps of ceiling cameras are believed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.localization import CeilingImage
from circumspect.localization.leap_guard import CONFIRMED, LEAP, LeapGuard

GREY = np.zeros((2, 2), np.uint8)


def seen(stamp, *cameras):
    return [CeilingImage(camera, stamp, GREY) for camera in cameras or "a"]


@given(st.lists(st.floats(0.01, LEAP - 0.01), min_size=1, max_size=20))
def test_images_that_follow_closely_are_believed(gaps):
    guard, after = LeapGuard("a"), -np.inf
    for stamp in np.cumsum(gaps):
        assert guard.until(seen(stamp), after) >= stamp
        after = stamp


@given(st.floats(LEAP + 0.01, 1e6), st.integers(CONFIRMED + 1, 20))
def test_a_usual_spacing_however_long_is_learnt(spacing, count):
    """The first ones wait, and are believed together; the others do not even wait."""
    guard, after = LeapGuard("a"), 0.0
    for n in range(1, count):
        until = guard.until(seen(spacing * n), after)
        assert (until >= spacing * n) == (n >= CONFIRMED)
        if until >= spacing * n:
            after = spacing * n


def test_a_leap_of_all_cameras_is_none():
    assert LeapGuard("ab").until(seen(500.0, "a", "b"), 0.0) == 500.0
    assert LeapGuard("ab").until(seen(500.0, "a"), 0.0) == LEAP
    assert LeapGuard("a").until(seen(500.0, "a"), 0.0) == LEAP
    assert LeapGuard("abc").until(seen(500.0, "a", "b"), 0.0) == LEAP


def test_what_follows_earlier_refutes_a_leap():
    guard = LeapGuard("a")
    assert [guard.until(seen(stamp), 0.0) for stamp in (5000.0, 100.0, 100.1)] == [LEAP] * 3
    assert guard.until(seen(100.2), 0.0) == 100.2
    # One pause does not make every leap a pause.
    assert guard.until(seen(5000.0), 100.2) == pytest.approx(100.2 + LEAP)


def test_at_the_end_a_second_one_confirms():
    guard = LeapGuard("a")
    guard.until(seen(0.0), -5.0)
    guard.until(seen(15.0), 0.0)
    assert guard.until_the_end(0.0) == LEAP
    guard.until(seen(30.0), 0.0)
    assert guard.until_the_end(0.0) == 30.0


@pytest.mark.parametrize("cameras", ["a", "abc"])
def test_two_photographs_far_apart_are_no_leap(cameras):
    """Nothing was ever close enough in time to tell of a clock."""
    guard = LeapGuard(cameras)
    guard.until(seen(0.0), -np.inf)
    assert guard.until(seen(15.0), 0.0) == LEAP
    assert guard.until_the_end(0.0) == 15.0
