"""Kernels of reconstruction agree with their NumPy twins."""

from __future__ import annotations

import numpy as np
import pytest
import reconstruction_reference as twin
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from circumspect.reconstruction import SightRays, _native

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


@given(seeds, st.integers(0, 60), st.integers(0, 60))
def test_added_keys_agree_with_their_twin(seed: int, one: int, other: int) -> None:
    rng = np.random.default_rng(seed)
    known = np.unique(rng.integers(-50, 50, one))
    keys = np.unique(np.concatenate([rng.integers(-50, 50, other), known[rng.random() < 0.7 :]]))
    found, expected = _native.added_keys(known, keys), twin.added_keys(known, keys)
    assert (found is None) == (expected is None)
    if found is not None:
        np.testing.assert_array_equal(found, expected)


@given(seeds, st.sampled_from([(2, 4), (1, 3), (3, 3)]), st.floats(0.3, 1.0))
@settings(max_examples=20)
def test_frame_surfaces_agree_with_their_twin(
    seed: int, blocks: tuple[int, int], filled: float
) -> None:
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[:37, :50]
    depth = (1.5 + 0.01 * u * rng.normal() + 0.01 * v * rng.normal()).clip(0.5, 3)
    depth[v > 20] += 0.4
    depth = (depth + rng.normal(0, 0.002, depth.shape)).astype(np.float32)
    depth[rng.random(depth.shape) > filled] = np.nan
    mask = rng.random(depth.shape) < filled
    pose = RigidTransform.from_exp_coords(rng.normal(size=6)).as_matrix()
    noise = (0.0012, 0.0019, 0.4, 0.003)
    rest = (mask, (58.0, 57.0, 24.5, 18.2), pose, noise, *blocks, 0.04, 0.2)
    found, expected = _native.frame_surface(depth, *rest), twin.frame_surface(depth, *rest)
    for one, other in zip(found, expected, strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_allclose(one, other, rtol=2e-4, atol=2e-5)


@pytest.mark.parametrize(
    ("change", "message"),
    [({"mask": np.ones((3, 3), bool)}, "mask"), ({"point_block": 0}, "blocks"),
     ({"normal_block": 3}, "blocks"), ({"normal_block": 5000}, "blocks")],
)  # fmt: skip
def test_wrong_sizes_of_a_frame_are_refused(change: dict, message: str) -> None:
    usual = {
        "depth": np.ones((4, 6), np.float32), "mask": np.ones((4, 6), bool),
        "camera": (5.0, 5.0, 2.0, 2.0), "pose": np.eye(4), "noise": (0.001, 0.002, 0.4, 0.003),
        "point_block": 2, "normal_block": 4, "jump": 0.04, "min_incidence_cosine": 0.2,
    }  # fmt: skip
    with pytest.raises(ValueError, match=message):
        _native.frame_surface(**(usual | change))
