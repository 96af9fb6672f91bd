"""Laws of the path made of fixes whose clocks were set back."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import PlanarPose
from circumspect.localization import LOST, TRACKED, SpaceFix
from circumspect.localization.space_track import LATE, SET_BACK, exclusion_reasons


def fixes(stamps, known=lambda number: True):
    """Fixes of these times [s], in the order of arrival."""
    here = PlanarPose(0.0, 0.0, 0.0)
    return [
        SpaceFix(stamp, TRACKED, here, None) if known(n) else SpaceFix(stamp, LOST, None, None)
        for n, stamp in enumerate(stamps)
    ]


def path(stamps, reasons):
    return [stamp for stamp, why in zip(stamps, reasons, strict=True) if why is None]


@given(st.lists(st.integers(0, 40), max_size=60))
def test_a_path_goes_forward_in_time(numbers):
    stamps = [float(number) for number in numbers]
    reasons = exclusion_reasons(fixes(stamps))
    assert all(one < next_one for one, next_one in pairwise(path(stamps, reasons)))


@given(st.lists(st.integers(0, 10**6), unique=True).map(sorted))
def test_a_clock_that_is_never_set_back_loses_no_fix(numbers):
    assert set(exclusion_reasons(fixes([float(number) for number in numbers]))) <= {None}


@given(st.integers(1, 20), st.integers(1, 20))
def test_of_two_overlapping_clocks_the_one_with_more_fixes_is_kept(old, new):
    stamps = [*(1000.0 + n for n in range(old)), *(float(n) for n in range(new))]
    reasons = exclusion_reasons(fixes(stamps))
    assert path(stamps, reasons) == (stamps[old:] if new > old else stamps[:old])


def test_a_clock_without_poses_is_excluded():
    stamps = [1000.0, 1001.0, 0.0, 1.0, 2.0]
    assert exclusion_reasons(fixes(stamps, lambda number: number < 2))[2:] == (SET_BACK,) * 3


def test_only_repeated_times_are_excluded():
    stamps = [0.0, 1.0, 2.0, 3.0, 1.5, 2.5, 3.5, 3.5]
    assert exclusion_reasons(fixes(stamps)) == (None,) * 4 + (SET_BACK,) * 2 + (None, LATE)
