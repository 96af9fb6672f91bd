from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import se3, se3_matrices
from circumspect.geometry.composition import distances

seeds = st.integers(0, 2**32 - 1)
sizes = st.sampled_from([0.0, 1e-9, 1e-5, 1.01e-4, 0.1, 1.0, 2.5, 3.1])


def change(seed: int, turn: float) -> np.ndarray:
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    return np.concatenate([turn * axis / np.linalg.norm(axis), rng.normal(size=3)])


@given(seeds, sizes)
def test_matrices_agree_with_rigid_transform(seed: int, turn: float) -> None:
    xi = change(seed, turn)
    T = se3.exp(xi)
    np.testing.assert_allclose(se3_matrices.exp(xi), T.as_matrix(), atol=1e-9)
    np.testing.assert_allclose(se3_matrices.log(T.as_matrix()), xi, atol=1e-7)
    np.testing.assert_allclose(se3_matrices.inverse(T.as_matrix()), T.inv().as_matrix(), atol=1e-12)


@given(seeds)
def test_batches_equal_single_calls(seed: int) -> None:
    changes = np.stack([change(seed + n, turn) for n, turn in enumerate((0.0, 1e-5, 1.0, 3.0))])
    motions = se3_matrices.exps(changes)
    np.testing.assert_allclose(motions, [se3_matrices.exp(one) for one in changes], atol=1e-9)
    np.testing.assert_allclose(se3_matrices.logs(motions), changes, atol=1e-7)
    np.testing.assert_array_equal(
        se3_matrices.adjoint(motions), [se3_matrices.adjoint(one) for one in motions]
    )


@given(seeds)
def test_inverse_inverts_a_batch(seed: int) -> None:
    many = np.stack([se3_matrices.exp(change(seed + n, 1.0)) for n in range(3)])
    np.testing.assert_allclose(
        se3_matrices.inverse(many) @ many, np.broadcast_to(np.eye(4), many.shape), atol=1e-12
    )


@given(seeds, sizes)
def test_distances_equal_those_of_the_relative_pose(seed: int, turn: float) -> None:
    start, xi = se3_matrices.exp(change(seed + 1, 1.0)), change(seed, turn)
    shift, turned = distances(start @ se3_matrices.exp(xi), start)
    assert turned == pytest.approx(turn, abs=1e-7)
    assert shift == pytest.approx(np.linalg.norm(se3_matrices.exp(xi)[:3, 3]), abs=1e-9)
