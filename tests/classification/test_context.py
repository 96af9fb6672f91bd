"""The object's size beside its grid."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification import Classifier, GridSpec
from circumspect.classification.context import (
    LOG_HEIGHT,
    LOG_MAJOR,
    LOG_MINOR,
    LOG_RADIUS,
    SCALE_KNOWN,
    VISIBILITY_KNOWN,
    WIDTH,
    grid_context,
)
from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid

SEEING = GridSpec(margin=1.1, visibility=True, metric=True)


def slab(length=1.6, width=0.8, height=0.7, count=40_000):
    points = np.random.default_rng(0).random((count, 3)) - 0.5
    return points * [length, width, height]


def context_of(points, metric=True):
    cloud = PointCloud(points)
    return SEEING.context(SEEING.inputs(cloud)[0], SEEING.bounds(cloud) if metric else None)


def test_lengths_are_those_of_the_object():
    context = context_of(slab())
    assert context.shape == (WIDTH,)
    assert context[SCALE_KNOWN] == 1
    assert context[VISIBILITY_KNOWN] == 0  # A cloud has no rays.
    assert np.exp(context[LOG_HEIGHT]) == pytest.approx(0.7, rel=0.12)
    assert np.exp(context[LOG_RADIUS]) == pytest.approx(np.hypot(0.8, 0.4), rel=0.06)
    assert np.exp(context[LOG_MAJOR]) == pytest.approx(1.6 / 12**0.5, rel=0.12)
    assert np.exp(context[LOG_MINOR]) == pytest.approx(0.8 / 12**0.5, rel=0.12)


@given(factor=st.floats(0.05, 20.0))
def test_lengths_grow_with_the_object(factor):
    first, second = context_of(slab(count=4000)), context_of(slab(count=4000) * factor)
    np.testing.assert_allclose(second[LOG_HEIGHT:] - first[LOG_HEIGHT:], np.log(factor), atol=1e-3)


@given(cells=st.integers(0, 31))
def test_a_turn_by_whole_cells_changes_nothing(cells):
    occupied = np.random.default_rng(1).random((32, 32, 32)) < 0.05
    first = grid_context(occupied, (1.0, 1.0), visible=False)
    turned = grid_context(np.roll(occupied, cells, axis=1), (1.0, 1.0), visible=False)
    np.testing.assert_allclose(first, turned, atol=1e-4)


def test_an_unknown_scale_is_stated_and_the_same_for_all_sizes():
    small, large = context_of(slab(), metric=False), context_of(slab() * 7, metric=False)
    np.testing.assert_array_equal(small, large)
    assert not small.any()


def test_visibility_is_known_where_rays_passed():
    grid = CylindricalGrid((32, 32, 32), 2.0, 2.0)
    seen = grid.trace([3.0, 0.0, 0.0], slab(count=500))
    context = SEEING.context(SEEING.input_of(seen)[None], grid)
    assert context[VISIBILITY_KNOWN] == 1


def test_networks_that_need_a_size_refuse_objects_without_one():
    input_spec = GridSpec(margin=1.1, visibility=True, metric=True, scale_required=True)
    with pytest.raises(InputError, match="state the unit"):
        input_spec.context(input_spec.inputs(PointCloud(slab(count=500)))[0], None)


def test_rectangular_grids_have_no_context():
    with pytest.raises(InputError, match="rectangular"):
        GridSpec("rectangular", visibility=True)


def test_networks_without_a_context_get_none():
    input_spec = GridSpec()
    assert input_spec.context(input_spec.inputs(PointCloud(slab(count=500)))[0]) is None


@pytest.mark.parametrize("coverage", [-0.1, 1.1, float("nan")])
def test_a_coverage_that_is_no_share_is_refused(coverage):
    cloud = make_furniture("chair", 3).sampled(2_000, 0)
    with pytest.raises(InputError, match="coverage must lie in 0 … 1"):
        Classifier.load(threads=1).classify(cloud, coverage=coverage)
