from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry.voxel_sums import (
    VoxelSums,
    coarser_keys,
    first_rows,
    group_maxima,
    group_sizes,
    patch_keys,
    voxel_keys,
)


def slow_sums(keys: np.ndarray, values: np.ndarray) -> dict[int, np.ndarray]:
    totals: dict[int, np.ndarray] = {}
    for key, row in zip(keys.tolist(), values, strict=True):
        totals[key] = totals.get(key, 0.0) + row
    return totals


def assert_same(sums: VoxelSums, expected: dict[int, np.ndarray]) -> None:
    assert sums.keys.tolist() == sorted(expected)
    for key, row in zip(sums.keys.tolist(), sums.totals, strict=True):
        np.testing.assert_allclose(row, expected[key], atol=1e-9)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(0, 60), other=st.integers(0, 60))
def test_sums_equal_a_dictionary_of_sums(seed: int, count: int, other: int) -> None:
    rng = np.random.default_rng(seed)
    keys, more = rng.integers(0, 12, count), rng.integers(0, 12, other)
    values, further = rng.normal(size=(count, 3)), rng.normal(size=(other, 3))
    one, two = VoxelSums.from_rows(keys, values), VoxelSums.from_rows(more, further)
    assert_same(one, slow_sums(keys, values))
    together = slow_sums(np.concatenate([keys, more]), np.concatenate([values, further]))
    assert_same(one.plus(two), together)
    assert_same(two.plus(one), together)
    assert_same(one, slow_sums(keys, values))


@given(seed=st.integers(0, 2**32 - 1), side=st.floats(0.002, 0.5))
def test_points_have_equal_keys_only_in_the_same_voxel(seed: int, side: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-4 * side, 4 * side, (80, 3))
    cells = [tuple(cell) for cell in np.floor(points / side).astype(int).tolist()]
    keys = voxel_keys(points, side).tolist()
    assert len(set(cells)) == len(set(keys)) == len(set(zip(cells, keys, strict=True)))


@given(seed=st.integers(0, 2**32 - 1), counts=st.lists(st.integers(0, 40), max_size=5))
def test_adding_several_tables_equals_adding_one_by_one_bit_for_bit(
    seed: int, counts: list[int]
) -> None:
    rng = np.random.default_rng(seed)
    first, *others = (
        VoxelSums.from_rows(rng.integers(0, 30, count), rng.normal(size=(count, 2)))
        for count in [20, *counts]
    )
    one_by_one = first
    for other in others:
        one_by_one = one_by_one.plus(other)
    at_once = first.plus(*others)
    np.testing.assert_array_equal(at_once.keys, one_by_one.keys)
    np.testing.assert_array_equal(at_once.totals, one_by_one.totals)


@given(seed=st.integers(0, 2**32 - 1), side=st.floats(0.002, 0.5))
def test_coarser_keys_equal_keys_of_voxels_of_twice_the_side(seed: int, side: float) -> None:
    cells = np.random.default_rng(seed).integers(-500, 500, (80, 3))
    # In the middle of cells, where no division rounds over a border.
    points = (cells + 0.5) * side
    np.testing.assert_array_equal(
        coarser_keys(voxel_keys(points, side)), voxel_keys(points, 2 * side)
    )


def test_two_sides_of_a_board_are_two_patches() -> None:
    points = np.full((3, 3), 0.01)
    normals = np.array([[0.1, 0.0, 0.9], [0.0, 0.2, -0.9], [0.0, 0.1, 0.8]])
    front, back, again = patch_keys(points, normals, 0.05)
    assert front == again != back


def test_group_functions_of_unsorted_keys() -> None:
    keys = np.array([7, -2, 7, 5, -2, 7])
    np.testing.assert_array_equal(group_sizes(keys), [3, 2, 3, 1, 2, 3])
    distinct, first = first_rows(keys)
    np.testing.assert_array_equal(distinct, [-2, 5, 7])
    np.testing.assert_array_equal(first, [1, 3, 0])
    np.testing.assert_array_equal(group_maxima(keys, np.arange(6.0)), [4, 3, 5])
    assert len(group_maxima(keys[:0], np.empty(0))) == 0
