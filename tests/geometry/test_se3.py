from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import se3

changes = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6).map(np.array)


@given(changes)
def test_log_inverts_exp(change: np.ndarray) -> None:
    np.testing.assert_allclose(se3.log(se3.exp(change)), change, atol=1e-9)


@given(changes, changes)
def test_adjoint_expresses_a_tangent_vector_in_the_target_frame(
    change: np.ndarray, small: np.ndarray
) -> None:
    T = se3.exp(change)
    one, other = T * se3.exp(small), se3.exp(se3.adjoint(T) @ small) * T
    np.testing.assert_allclose(one.as_matrix(), other.as_matrix(), atol=1e-9)


@given(changes, changes)
def test_right_jacobian_inverse_is_the_derivative_of_the_logarithm(
    change: np.ndarray, direction: np.ndarray
) -> None:
    change, step = 0.5 * change, 1e-6
    ahead = se3.log(se3.exp(change) * se3.exp(step * direction))
    behind = se3.log(se3.exp(change) * se3.exp(-step * direction))
    expected = se3.right_jacobian_inverse(change) @ direction
    np.testing.assert_allclose((ahead - behind) / (2 * step), expected, atol=2e-4)


@given(changes, changes, changes)
def test_level_error_derivative_equals_finite_differences(
    pose: np.ndarray, mount: np.ndarray, direction: np.ndarray
) -> None:
    T, X, step = se3.exp(pose), se3.exp(mount), 1e-6
    _, J = se3.level_error(T, X)
    ahead, _ = se3.level_error(T * se3.exp(step * direction), X)
    behind, _ = se3.level_error(T * se3.exp(-step * direction), X)
    difference = (ahead - behind) / (2 * step)
    # Roll and pitch are exact for a level base only; the height always is.
    np.testing.assert_allclose(difference[2], (J @ direction)[2], atol=1e-6)
    level_X = X
    T_level = X  # a base at the origin: level by construction
    error, J = se3.level_error(T_level, level_X)
    np.testing.assert_allclose(error, 0, atol=1e-12)
    ahead, _ = se3.level_error(T_level * se3.exp(step * direction), level_X)
    behind, _ = se3.level_error(T_level * se3.exp(-step * direction), level_X)
    np.testing.assert_allclose((ahead - behind) / (2 * step), J @ direction, atol=1e-6)


@given(changes, st.integers(0, 2**32 - 1))
def test_moved_information_is_the_inverse_of_moved_covariance(
    change: np.ndarray, seed: int
) -> None:
    root = np.random.default_rng(seed).normal(size=(6, 6))
    covariance = root @ root.T + np.eye(6)
    T = se3.exp(change)
    moved = se3.moved_information(T, np.linalg.inv(covariance))
    np.testing.assert_allclose(
        np.linalg.inv(moved), se3.moved_covariance(T, covariance), rtol=1e-6, atol=1e-6
    )
