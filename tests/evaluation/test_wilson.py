"""Intervals of shares."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from circumspect.evaluation.accuracy import wilson_interval

COUNTS = st.integers(1, 300).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


@given(COUNTS)
def test_equals_scipy(counts):
    hits, count = counts
    expected = binomtest(hits, count).proportion_ci(method="wilson")
    assert wilson_interval(hits, count) == pytest.approx((expected.low, expected.high), abs=1e-6)


@given(COUNTS)
def test_the_interval_contains_the_share_and_is_symmetric(counts):
    hits, count = counts
    low, high = wilson_interval(hits, count)
    assert 0 <= low <= hits / count + 1e-12
    assert hits / count - 1e-12 <= high <= 1
    assert high > low
    other = wilson_interval(count - hits, count)
    assert (1 - other[1], 1 - other[0]) == pytest.approx((low, high))


@pytest.mark.parametrize(("hits", "count"), [(0, 0), (3, 2), (-1, 5)])
def test_an_invalid_share_is_refused(hits, count):
    with pytest.raises(ValueError, match="no share"):
        wilson_interval(hits, count)
