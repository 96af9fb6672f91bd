"""Farthest point sampling against its definition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry.farthest_points import farthest_points


def some_points(seed: int, count: int, copies: int = 0, kind: type = np.float64):
    """Random points; the first ones are repeated."""
    points = np.random.default_rng(seed).normal(size=(count, 3)).astype(kind)
    return np.concatenate([points, points[:copies]])


@given(seed=st.integers(0, 2**20), count=st.integers(2, 40), copies=st.integers(0, 5))
def test_each_point_is_the_farthest_from_those_before_it(seed, count, copies):
    points = some_points(seed, count, min(copies, count))
    first = seed % len(points)
    chosen = farthest_points(points, len(points), first)
    assert chosen[0] == first
    away = np.linalg.norm(points[:, None] - points, axis=2)
    for i in range(1, len(points)):
        gaps = away[:, chosen[:i]].min(axis=1)
        assert gaps[chosen[i]] == pytest.approx(gaps.max(), abs=1e-9)


@given(seed=st.integers(0, 2**20), count=st.integers(1, 40), copies=st.integers(0, 40))
def test_no_point_is_chosen_twice_although_there_are_copies(seed, count, copies):
    points = some_points(seed, count, min(copies, count))
    chosen = farthest_points(points, len(points))
    assert sorted(chosen.tolist()) == list(range(len(points)))


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@given(seed=st.integers(0, 2**20), count=st.integers(2, 60))
def test_every_prefix_is_the_sample_of_that_many_points(kind, seed, count):
    points = some_points(seed, count, kind=kind)
    chosen = farthest_points(points, count)
    for fewer in {1, count // 2, count - 1} - {0}:
        np.testing.assert_array_equal(farthest_points(points, fewer), chosen[:fewer])
        # Of a sample, too: the stages of a network may take one order in turn.
        of_sample = farthest_points(points[chosen], fewer)
        np.testing.assert_array_equal(of_sample, np.arange(fewer))


def test_points_that_are_all_the_same():
    assert sorted(farthest_points(np.ones((4, 3)), 4, 2).tolist()) == [0, 1, 2, 3]


def test_they_cover_the_cloud_evenly():
    rng = np.random.default_rng(0)
    cloud = rng.random((3000, 3)) * [1, 1, 0]
    chosen = cloud[farthest_points(cloud, 100)]
    gaps = np.linalg.norm(chosen[:, None] - chosen, axis=2) + 9 * np.eye(100)
    assert gaps.min() > 0.07
    # The radius of the covering is at most the smallest gap (Gonzalez 1985).
    assert np.linalg.norm(cloud[:, None] - chosen, axis=2).min(axis=1).max() <= gaps.min()
