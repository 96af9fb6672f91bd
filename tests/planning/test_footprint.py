from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.planning.plan_view import (
    CELL_M,
    MAX_CELLS,
    MAX_CENTRE_POINTS,
    MIN_CELLS,
    cell_keys,
    cell_middles,
    centre_of,
    footprint,
)


def sorted_footprint(points_xyz: np.ndarray, least: int) -> np.ndarray:
    keys, counts = np.unique(cell_keys(points_xyz[:, :2], CELL_M), return_counts=True)
    if (counts >= least).sum() >= MIN_CELLS:
        keys = keys[counts >= least]
    return cell_middles(keys, CELL_M)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 400),
    st.sampled_from([0.01, 0.3, 3.0, 200.0]),
    st.sampled_from([0.0, 7.0, -5e4]),
    st.booleans(),
)
def test_counting_and_sorting_give_the_same_footprint(
    seed: int, count: int, spread: float, away: float, large: bool
) -> None:
    points = np.random.default_rng(seed).normal(away, spread, (count, 3))
    found = footprint(points, voxel=CELL_M if large else CELL_M / 2)
    np.testing.assert_array_equal(found, sorted_footprint(points, least=1 if large else 2))
    assert found.shape[1] == 2


def test_of_two_points_far_apart_the_cells_between_are_not_counted() -> None:
    apart = 2 * CELL_M * MAX_CELLS
    points = np.array([[0.0, 0.0, 0.5], [apart, apart, 0.5]])
    np.testing.assert_allclose(footprint(points)[:, 0], [0.0, apart], atol=CELL_M)


@pytest.mark.parametrize("count", [3, 500, 5 * MAX_CENTRE_POINTS])
def test_the_centre_of_many_points_is_accurate(count: int) -> None:
    points = np.random.default_rng(1).uniform([1.0, -2.0, 0.0], [3.0, -1.0, 1.0], (count, 3))
    wanted = (points.min(axis=0) + points.max(axis=0))[:2] / 2
    np.testing.assert_allclose(centre_of(points), wanted, atol=0.02)
