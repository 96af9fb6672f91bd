from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.mapping import rigid_matrix, se3
from circumspect.mapping.pose_distance import distances

seeds = st.integers(0, 2**32 - 1)
sizes = st.sampled_from([0.0, 1e-9, 1e-5, 1.01e-4, 0.1, 1.0, 2.5, 3.1])


def change(seed: int, turn: float) -> np.ndarray:
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    return np.concatenate([turn * axis / np.linalg.norm(axis), rng.normal(size=3)])


@given(seeds, sizes)
def test_matrices_say_the_same_as_scipy(seed: int, turn: float) -> None:
    xi = change(seed, turn)
    T = se3.exp(xi)
    np.testing.assert_allclose(rigid_matrix.exp(xi), T.as_matrix(), atol=1e-9)
    np.testing.assert_allclose(rigid_matrix.log(T.as_matrix()), xi, atol=1e-7)
    np.testing.assert_allclose(rigid_matrix.inverse(T.as_matrix()), T.inv().as_matrix(), atol=1e-12)


@given(seeds)
def test_many_at_once_are_as_one_by_one(seed: int) -> None:
    changes = np.stack([change(seed + n, turn) for n, turn in enumerate((0.0, 1e-5, 1.0, 3.0))])
    motions = rigid_matrix.exps(changes)
    np.testing.assert_allclose(motions, [rigid_matrix.exp(one) for one in changes], atol=1e-9)
    np.testing.assert_allclose(rigid_matrix.logs(motions), changes, atol=1e-7)
    np.testing.assert_array_equal(
        rigid_matrix.adjoint(motions), [rigid_matrix.adjoint(one) for one in motions]
    )


@given(seeds)
def test_many_are_turned_round_at_once(seed: int) -> None:
    many = np.stack([rigid_matrix.exp(change(seed + n, 1.0)) for n in range(3)])
    np.testing.assert_allclose(
        rigid_matrix.inverse(many) @ many, np.broadcast_to(np.eye(4), many.shape), atol=1e-12
    )


@given(seeds, sizes)
def test_distances_are_those_of_the_motion_between(seed: int, turn: float) -> None:
    start, xi = rigid_matrix.exp(change(seed + 1, 1.0)), change(seed, turn)
    shift, turned = distances(start @ rigid_matrix.exp(xi), start)
    assert turned == pytest.approx(turn, abs=1e-7)
    assert shift == pytest.approx(np.linalg.norm(rigid_matrix.exp(xi)[:3, 3]), abs=1e-9)
