"""Kernels of reconstruction agree with their NumPy twins."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.reconstruction import SightRays, _native
from circumspect.reconstruction import numpy_twin as twin

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(0, 200))
def test_surface_sums_and_means_agree_with_their_twins(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    points, normals = rng.normal(size=(count, 3)), rng.normal(size=(count, 3)).astype(np.float32)
    normals[rng.random(count) < 0.2] = 0
    weights, keys = rng.uniform(1, 9, count).astype(np.float32), rng.integers(0, 40, count)
    found, sums = _native.surface_sums(points, normals, weights, keys)
    expected, totals = twin.surface_sums(points, normals, weights, keys)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_allclose(sums, totals, atol=1e-9)
    for one, other in zip(_native.surface_means(totals), twin.surface_means(totals), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


@given(seeds, st.integers(0, 60), st.integers(0, 60))
def test_merged_rays_keep_the_first_set_for_equal_keys(seed: int, one: int, other: int) -> None:
    rng = np.random.default_rng(seed)

    def table(count: int) -> tuple[np.ndarray, ...]:
        keys = np.unique(rng.integers(-50, 50, count))
        ends = rng.normal(size=(2, len(keys), 3)).astype(np.float32)
        return keys, *ends, rng.random(len(keys)) < 0.5

    known, more = table(one), table(other)
    merged = SightRays(*_native.merge_rays(*known, *more))
    expected = {int(row[0]): row[1:] for row in zip(*more, strict=True)}
    expected |= {int(row[0]): row[1:] for row in zip(*known, strict=True)}
    assert merged.keys.tolist() == sorted(expected)
    for number, key in enumerate(merged.keys.tolist()):
        origin, end, hit = expected[key]
        np.testing.assert_array_equal(merged.origins_xyz[number], origin)
        np.testing.assert_array_equal(merged.ends_xyz[number], end)
        assert merged.on_object[number] == hit


def test_arrays_of_different_lengths_are_refused() -> None:
    points, normals = np.zeros((3, 3)), np.zeros((2, 3), np.float32)
    with pytest.raises(ValueError, match="one normal, weight and key per point"):
        _native.surface_sums(points, normals, np.ones(3, np.float32), np.arange(3))
    with pytest.raises(ValueError, match="weight, point and normal"):
        _native.surface_means(np.zeros((3, 6)))
    rays = np.arange(3), np.zeros((3, 3), np.float32), np.zeros((3, 3), np.float32)
    with pytest.raises(ValueError, match="one origin, end and flag per key"):
        _native.merge_rays(*rays, np.ones(3, bool), *rays, np.ones(2, bool))
