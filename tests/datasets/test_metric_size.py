"""Sizes of objects of unknown unit."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets.scan_sources import INCH, SIZES, metres_per_unit, size_factors

length = st.floats(0.01, 1e4)


def test_inches_are_recognised_by_plausible_sizes():
    assert metres_per_unit("chair", np.array([20.0, 22.0, 35.0]), np.random.default_rng(0)) == INCH


@given(
    label=st.sampled_from(sorted(SIZES)),
    extent=st.tuples(length, length, length),
    seed=st.integers(0, 100),
)
def test_sizes_lie_in_the_class_range_where_proportions_allow_it(label, extent, seed):
    scale = metres_per_unit(label, np.array(extent), np.random.default_rng(seed))
    assert 0 < scale < np.inf
    (low, high), (short, long) = SIZES[label]
    height, side = extent[2], max(extent[:2])
    if max(low / height, short / side) <= min(high / height, long / side):
        assert low * 0.999 <= scale * height <= high * 1.001
        assert short * 0.999 <= scale * side <= long * 1.001


@given(
    label=st.sampled_from(sorted(SIZES)),
    extent=st.tuples(*[st.floats(0.05, 5.0)] * 3),
    share=st.floats(0.0, 1.0),
)
def test_other_sizes_lie_in_the_class_range_too(label, extent, share):
    low, high = size_factors(label, np.array(extent))
    assert 0 < low <= 1 <= high
    (shortest, tallest), (narrowest, widest) = SIZES[label]
    side, height = max(extent[:2]), extent[2]
    if shortest <= height <= tallest and narrowest <= side <= widest:
        factor = low ** (1 - share) * high**share
        assert shortest * 0.999 <= factor * height <= tallest * 1.001
        assert narrowest * 0.999 <= factor * side <= widest * 1.001
