"""Sizes of objects of unknown unit."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets.metric_size import INCH, SIZES, metres_per_unit

length = st.floats(0.01, 1e4)


def test_inches_are_kept_where_they_make_sense():
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
