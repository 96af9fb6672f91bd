"""Kernels for keys and sums agree with their NumPy twins."""

from __future__ import annotations

import groups_reference as twin
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import _native

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(0, 300), st.integers(1, 400))
def test_groups_and_sums_agree_with_their_twins(seed: int, count: int, different: int) -> None:
    rng = np.random.default_rng(seed)
    keys = rng.integers(-different, different, count) * (2**53 + 1)
    for one, other in zip(_native.groups(keys), twin.groups(keys), strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(_native.group_sizes(keys), twin.group_sizes(keys))
    for dtype in (np.float32, np.float64):
        values = rng.normal(size=(count, 3)).astype(dtype)
        found, sums = _native.row_sums(keys, values)
        expected, totals = twin.row_sums(keys, values)
        np.testing.assert_array_equal(found, expected)
        np.testing.assert_allclose(sums, totals, atol=1e-9)
    half = count // 2
    tables = (
        *twin.row_sums(keys[:half], values[:half]),
        *twin.row_sums(keys[half:], values[half:]),
    )
    found, sums = _native.table_sum(*tables)
    expected, totals = twin.table_sum(*tables)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_allclose(sums, totals, atol=1e-9)


@given(seeds, st.integers(0, 200), st.sampled_from([np.float32, np.float64]))
def test_cell_and_patch_keys_agree_with_their_twins(seed: int, count: int, dtype: type) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(0, 3, (count, 3)).astype(dtype)
    for bits, offset in ((20, 1 << 19), (15, 0), (6, 0)):
        np.testing.assert_array_equal(
            _native.packed_cells(points, 0.03, bits, offset),
            twin.packed_cells(points, 0.03, bits, offset),
        )
    cells = twin.packed_cells(points, 0.03, 20, 0)
    normals = np.round(points)  # with equal components, too
    np.testing.assert_array_equal(
        _native.patch_keys(cells, normals), twin.patch_keys(cells, normals)
    )


@given(seeds, st.integers(0, 200), st.integers(0, 300))
def test_split_means_agree_with_their_twin_and_keep_the_total(
    seed: int, known: int, count: int
) -> None:
    rng = np.random.default_rng(seed)
    table = np.unique(rng.integers(-200, 200, known)) * (2**53 + 1)
    totals = rng.uniform(1, 2, (len(table), 2))
    keys = rng.integers(-200, 200, count) * (2**53 + 1)
    parts = _native.split_means(table, totals, keys)
    np.testing.assert_array_equal(parts, twin.split_means(table, totals, keys))
    # Each mean with at least one row is split completely.
    expected = (totals[:, 0] / totals[:, 1])[np.isin(table, keys)].sum()
    assert parts.sum() == pytest.approx(expected)


def test_arrays_of_different_lengths_are_refused() -> None:
    keys, rows = np.arange(4), np.zeros((3, 2))
    with pytest.raises(ValueError, match="one row per key"):
        _native.row_sums(keys, rows)
    with pytest.raises(ValueError, match="equal numbers of columns"):
        _native.table_sum(keys[:3], rows, keys[:3], np.zeros((3, 5)))
    for totals in (np.zeros((3, 3)), np.zeros((2, 2))):
        with pytest.raises(ValueError, match="sum and count per key"):
            _native.split_means(keys[:3], totals, keys)
    with pytest.raises(ValueError, match="one normal per cell"):
        _native.patch_keys(keys, np.zeros((3, 3)))
    with pytest.raises(ValueError, match="side and bits"):
        _native.packed_cells(np.zeros((3, 3)), 0.1, 30, 0)
