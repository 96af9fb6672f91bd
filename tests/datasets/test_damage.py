import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets import Augmentation
from circumspect.datasets import augmentation as kinds
from circumspect.datasets.augmentation import damaged
from circumspect.datasets.augmented_clouds import _changes
from circumspect.geometry import short_edge_triangles

seeds = st.integers(0, 2**32 - 1)
FEW = np.random.default_rng(0).uniform(-0.5, 0.5, (400, 3)).astype(np.float32)


def rows(samples):
    return {tuple(row) for row in samples.tolist()}


@given(seeds, st.integers(1, 400))
def test_damage_never_removes_all_points(seed, count):
    left = damaged(FEW[:count], np.random.default_rng(seed))
    assert left.dtype == np.float32
    assert left.ndim == 2
    assert len(left) >= 1
    assert np.isfinite(left).all()


@given(seeds)
def test_damage_repeats_with_its_seed(seed):
    a, b = (damaged(FEW, np.random.default_rng(seed)) for _ in range(2))
    np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("takes", [kinds._cut, kinds._holed])
@given(seed=seeds)
def test_a_tenth_to_half_is_missing_and_the_rest_stays(takes, seed):
    left = takes(FEW, np.random.default_rng(seed))
    assert 0.48 <= len(left) / len(FEW) <= 0.92
    order = [FEW.tolist().index(row) for row in left.tolist()]
    assert order == sorted(order)


@given(seeds)
def test_a_cut_is_a_plane(seed):
    left = kinds._cut(FEW, np.random.default_rng(seed))
    gone = np.array(sorted(rows(FEW) - rows(left)))
    # The same draw again gives the plane.
    direction = np.random.default_rng(seed).normal(size=3)
    assert (left @ direction).max() <= (gone @ direction).min() + 1e-6


@given(seeds)
def test_strays_lie_in_the_ball_round_the_object(seed):
    strewn = kinds._with_strays(FEW, np.random.default_rng(seed))
    np.testing.assert_array_equal(strewn[: len(FEW)], FEW)
    assert len(strewn) <= 1.01 * len(FEW)
    assert np.linalg.norm(strewn, axis=1).max() <= np.linalg.norm(FEW, axis=1).max() * (1 + 1e-6)


@given(seeds)
def test_a_lean_keeps_the_shape_and_the_axis_within_ten_degrees(seed):
    leaning = kinds._leaning(np.eye(3, dtype=np.float32), np.random.default_rng(seed))
    np.testing.assert_allclose(leaning @ leaning.T, np.eye(3), atol=1e-6)
    assert leaning[2, 2] >= np.cos(np.radians(kinds.MAX_LEAN_DEG)) - 1e-6


def test_all_four_kinds_of_damage_occur():
    found = [damaged(FEW, np.random.default_rng(seed)) for seed in range(60)]
    fewer = sum(len(one) < len(FEW) for one in found)
    more = sum(len(one) > len(FEW) for one in found)
    assert 15 < fewer < 45
    assert 5 < more < 25
    assert any(len(one) == len(FEW) and not np.array_equal(one, FEW) for one in found)


@pytest.mark.parametrize("seed", range(5))
def test_damaged_variants_are_normalised_again(seed):
    points = np.random.default_rng(1).uniform(-1, 1, (1024, 3)).astype(np.float32)
    faces = short_edge_triangles(points, reach=4.0).faces
    still = {"thin": 1.0, "holes": 0.0, "shift": 0.0, "scale": (1.0, 1.0)}
    changed = Augmentation(damage=1.0, **still).apply(points, faces, np.random.default_rng(seed))
    extent = max(np.hypot(changed[:, 0], changed[:, 1]).max(), np.abs(changed[:, 2]).max())
    assert extent == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(changed.mean(axis=0), 0.0, atol=1e-4)


def test_without_damage_cached_grids_keep_their_key():
    assert "damage" not in _changes(Augmentation())
    assert _changes(Augmentation(damage=0.1))["damage"] == 0.1
