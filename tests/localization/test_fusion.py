from __future__ import annotations

import numpy as np
import pytest
from ceiling_world import unlike
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.localization import TagPose, agreeing, fused


def word(x, y, yaw, sigma, turn=0.0):
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    noise = R @ np.diag([sigma, 2 * sigma, 3 * sigma]) ** 2 @ R.T
    return TagPose(PlanarPose(x, y, yaw), noise, noise / 4, 5.0)


near = st.floats(-0.01, 0.01)
WORDS = st.lists(
    st.builds(word, near, near, st.floats(3.10, 3.18), st.floats(1e-3, 1e-2), st.floats(0, 3)),
    min_size=1,
    max_size=6,
)


@given(WORDS, st.randoms())
def test_the_order_of_cameras_does_not_matter(words, chance):
    shuffled = list(words)
    chance.shuffle(shuffled)
    one, other = fused(words), fused(shuffled)
    np.testing.assert_allclose(unlike(one.T_map_base, other.T_map_base), 0, atol=1e-12)
    np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-9, atol=1e-18)
    sets = {frozenset(id(words[i]) for i in group) for group in agreeing(words, 21.1)}
    assert sets == {frozenset(id(shuffled[i]) for i in group) for group in agreeing(shuffled, 21.1)}


@given(WORDS)
def test_fusion_adds_information(words):
    together = fused(words)
    information = sum(np.linalg.inv(w.covariance) for w in words)
    np.testing.assert_allclose(together.covariance @ information, np.eye(3), atol=1e-6)
    for one in words:
        assert np.trace(together.covariance) <= np.trace(one.covariance) * (1 + 1e-9)


def test_two_equal_cameras_halve_the_variance():
    one = word(1.0, 2.0, 0.3, 0.002)
    np.testing.assert_allclose(fused([one]).covariance, one.covariance, rtol=1e-9)
    np.testing.assert_allclose(fused([one, one]).covariance, one.covariance / 2, rtol=1e-9)
    with pytest.raises(InputError):
        fused([])


def test_outliers_are_excluded():
    words = [word(0, 0, 0, 0.001), word(0.05, 0, 0, 0.001), word(0.001, 0, 0, 0.001)]
    assert agreeing(words, 21.1) == [(0, 2)]
    assert agreeing(words[:2], 21.1) == [(0,), (1,)]
    assert agreeing([*words, word(0.051, 0, 0, 0.001)], 21.1) == [(0, 2), (1, 3)]
    assert agreeing(words[:1], 21.1) == [(0,)]
    assert agreeing([], 21.1) == []


def test_of_two_overlapping_groups_the_closer_one_is_kept():
    words = [word(0, 0, 0, 0.001), word(0.004, 0, 0, 0.001), word(0.0085, 0, 0, 0.001)]
    assert agreeing(words, 21.1) == [(0, 1)]
