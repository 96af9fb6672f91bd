import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets import Augmentation
from circumspect.geometry import short_edge_triangles

STILL = Augmentation(mirror=0, stretch=0, jitter=0, shift=0, scale=(1.0, 1.0), thin=1.0, holes=0.0)


@pytest.fixture(scope="module")
def ball():
    rng = np.random.default_rng(0)
    points = rng.standard_normal((400, 3)).astype(np.float32)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points, short_edge_triangles(points, reach=4.0).faces


def test_without_random_parts_clouds_are_only_normalised(ball):
    points, triangles = ball
    changed = STILL.apply(points * 7 + 3, triangles, np.random.default_rng(0))
    vertices = changed[: len(points)]
    extent = max(np.hypot(vertices[:, 0], vertices[:, 1]).max(), np.abs(vertices[:, 2]).max())
    assert extent == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(vertices.mean(axis=0), 0, atol=1e-5)


@given(seed=st.integers(0, 2**32 - 1))
def test_same_seed_same_object(ball, seed):
    points, triangles = ball
    first = Augmentation().apply(points, triangles, np.random.default_rng(seed))
    second = Augmentation().apply(points, triangles, np.random.default_rng(seed))
    np.testing.assert_array_equal(first, second)
    assert np.isfinite(first).all()
    assert len(first) > 0


@given(seed=st.integers(0, 2**32 - 1))
def test_axes_are_never_turned(seed):
    """Points on the x axis stay on it whatever is drawn, but for shift and jitter."""
    points = np.zeros((50, 3), np.float32)
    points[:, 0] = np.linspace(-1, 1, 50)
    still = Augmentation(jitter=0, shift=0)
    changed = still.apply(points, np.array([[0, 1, 2]]), np.random.default_rng(seed))
    np.testing.assert_allclose(changed[:, 1:], 0, atol=1e-6)


def test_mirror_swaps_left_and_right(ball):
    points, triangles = ball
    lopsided = points.copy()
    lopsided[:, 0] = np.abs(lopsided[:, 0]) ** 2
    always = Augmentation(
        mirror=1, stretch=0, jitter=0, shift=0, scale=(1, 1), thin=1.0, holes=0
    ).apply(lopsided, triangles, np.random.default_rng(0))
    never = STILL.apply(lopsided, triangles, np.random.default_rng(0))
    np.testing.assert_allclose(always[:400] * [-1, 1, 1], never[:400], atol=1e-6)


def test_holes_take_points_away(ball):
    points, triangles = ball
    holed = Augmentation(holes=1.0, hole_radius=(0.3, 0.3), thin=1.0)
    whole = Augmentation(holes=0.0, thin=1.0)
    less = holed.apply(points, triangles, np.random.default_rng(1))
    all_of = whole.apply(points, triangles, np.random.default_rng(1))
    assert len(less) < len(all_of)
