"""Kernels of tracking agree with their NumPy references."""

from __future__ import annotations

import numpy as np
import pytest
import smoother_reference
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.geometry import se3_matrices
from circumspect.tracking import _native, smoother_window
from circumspect.tracking.smoother_window import CAUCHY_SCALE, Window, WindowFactors, WindowPrior

seeds = st.integers(0, 2**32 - 1)
sizes = st.integers(1, 16)
spreads = st.sampled_from([0.0, 1e-9, 1e-4, 1e-2, 0.3, 3.0])


def informations(rng: np.random.Generator, count: int, size: int, known: float) -> np.ndarray:
    """(count, size, size) for different units; zero unless known, singular where it is."""
    rows = size - 1 if known < 1 else size
    roots = rng.normal(size=(count, rows, size)) * 10 ** rng.uniform(0, 3, (count, 1, size))
    roots[rng.random(count) >= known] = 0
    return np.swapaxes(roots, 1, 2) @ roots


def transforms(rng: np.random.Generator, count: int, spread: float = 1.0) -> np.ndarray:
    return se3_matrices.exps(rng.normal(size=(count, 6)) * spread)


def random_window(seed: int, n: int, spread: float) -> Window:
    """A window whose measurements are wrong by about the spread [rad, m]."""
    rng = np.random.default_rng(seed)
    known, level = rng.choice([0.0, 0.5, 0.9], 2)
    poses, mounts = transforms(rng, n), transforms(rng, n)
    scale = 1 + rng.normal(size=2) * min(spread, 0.3)
    by_scale = rng.normal(size=(n - 1, 6, 2)) * (rng.random((n - 1, 1, 1)) < 0.7)
    between = se3_matrices.inverse(poses[:-1]) @ poses[1:]
    slip = se3_matrices.exps(-by_scale @ (scale - 1)) if n > 1 else between
    factors = WindowFactors(
        between @ transforms(rng, n - 1, spread) @ slip,
        by_scale,
        informations(rng, n - 1, 6, 1),
        poses @ transforms(rng, n, spread),
        informations(rng, n, 6, known),
        mounts,
        informations(rng, n, 3, level),
    )
    prior = WindowPrior(
        poses[0] @ transforms(rng, 1, spread)[0],
        scale + rng.normal(size=2) * spread,
        informations(rng, 1, 8, 1)[0],
    )
    return Window(poses, scale, prior, factors)


@settings(max_examples=300)
@given(seeds, sizes, spreads, st.booleans())
def test_linearised_agrees(seed: int, n: int, spread: float, is_oldest: bool) -> None:
    window, count = random_window(seed, n, spread), 1 if is_oldest else None
    H, gradient = window.linearised(count)
    expected_H, expected = smoother_reference.linearised(window, count)
    assert H.shape == expected_H.shape
    units = np.sqrt(np.diag(expected_H))
    np.testing.assert_allclose(H / np.outer(units, units), expected_H / np.outer(units, units),
                               atol=1e-9)  # fmt: skip
    np.testing.assert_allclose(gradient / units, expected / units, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "angle", [0.0, 1e-12, 1e-8, 1e-5, 9.99e-4, 1.001e-3, 0.1, 2.0, 3.0, np.pi - 1e-4, np.pi - 1e-9]
)
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0.6, 0.48, -0.64)])
def test_small_and_half_turns_are_exact(angle: float, axis: tuple[float, ...]) -> None:
    """The gradient of a unit prior is the logarithm of the pose, times its Jacobian."""
    xi = np.array([*(angle * np.array(axis)), 0.3, -2.0, 0.7])
    prior = WindowPrior(np.eye(4), np.ones(2), np.eye(8))
    window = Window.from_prior(prior).moved(np.array([*xi, 0.0, 0.0]))
    np.testing.assert_allclose(window.poses, se3_matrices.exps(xi[None]), atol=1e-14)
    H, gradient = window.linearised()
    expected_H, expected = smoother_reference.linearised(window)
    np.testing.assert_allclose(H, expected_H, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(gradient, expected, rtol=1e-10, atol=1e-10)


@given(seeds, sizes, spreads)
def test_step_and_covariance_solve_the_equations(seed: int, n: int, spread: float) -> None:
    window = random_window(seed, n, spread)
    H, gradient = window.linearised()
    step, covariance = window.gauss_newton_step()
    units = np.sqrt(np.diag(H))
    scaled = H / np.outer(units, units)
    tolerance = 1e-14 * np.linalg.cond(scaled)
    expected = -np.linalg.solve(scaled, gradient / units)
    np.testing.assert_allclose(step * units, expected, atol=tolerance * np.abs(expected).max())
    expected = np.linalg.inv(scaled)[-8:, -8:]
    found = covariance * np.outer(units[-8:], units[-8:])
    np.testing.assert_allclose(found, expected, atol=tolerance * np.abs(expected).max())
    np.testing.assert_array_equal(covariance, covariance.T)


@given(seeds, st.integers(1, 12), st.floats(0, 1))
def test_solved_agrees_for_any_sparsity(seed: int, size: int, density: float) -> None:
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(size, size)) * (rng.random((size, size)) < density)
    A, b, count = A @ A.T + np.eye(size), rng.normal(size=size), int(rng.integers(0, size + 1))
    solution, covariance = _native.solved(A, b, count)
    np.testing.assert_allclose(solution, np.linalg.solve(A, b), atol=1e-10)
    expected = np.linalg.inv(A)[size - count :, size - count :]
    np.testing.assert_allclose(covariance, expected, atol=1e-10)


@given(seeds, st.integers(2, 16), st.sampled_from([0.0, 1e-3, 0.1]))
def test_prior_is_the_schur_complement_of_the_oldest_pose(seed: int, n: int, spread: float) -> None:
    window = random_window(seed, n, spread)
    H, gradient = smoother_reference.linearised(window, 1)
    gain = np.linalg.solve(H[:6, :6], H[:6, 6:]).T
    information, left = H[6:, 6:] - gain @ H[:6, 6:], gradient[6:] - gain @ gradient[:6]
    step = -np.linalg.solve(information, left)
    covariance = np.linalg.inv(information)
    drift = smoother_window.SCALE_DRIFT**2 * (window.factors.by_scale[0] ** 2).sum(axis=0) ** 0.5
    covariance[6:, 6:] += np.diag(drift)
    rest = window.without_oldest()
    assert len(rest.poses) == n - 1
    tolerance = 1e-12 * np.linalg.cond(covariance)
    np.testing.assert_allclose(
        rest.prior.information @ covariance, np.eye(8), atol=1e-9 + tolerance
    )
    # The step is solved for with the oldest pose in it.
    units = np.sqrt(np.diag(H))
    tolerance = 1e-12 * np.linalg.cond(H / np.outer(units, units))
    second = window.poses[1] @ se3_matrices.exps(step[None, :6])[0]
    np.testing.assert_allclose(rest.prior.T_map_camera, second, atol=1e-9 + tolerance)
    np.testing.assert_allclose(rest.prior.scale, window.scale + step[6:], atol=1e-9 + tolerance)


@given(seeds, sizes, spreads)
def test_moving_the_map_changes_no_equation(seed: int, n: int, spread: float) -> None:
    """Except for level factors, which know the vertical."""
    window = random_window(seed, n, spread)
    window = Window(
        window.poses,
        window.scale,
        window.prior,
        window.factors._replace(level_information=np.zeros((n, 3, 3))),
    )
    moved = window.transformed(transforms(np.random.default_rng(seed), 1)[0])
    units = np.sqrt(np.diag(window.linearised()[0]))
    for one, other, unit in zip(
        moved.linearised(), window.linearised(), (np.outer(units, units), units), strict=True
    ):
        np.testing.assert_allclose(one / unit, other / unit, rtol=1e-8, atol=1e-8)


@given(seeds, sizes)
def test_measurements_without_information_have_no_effect(seed: int, n: int) -> None:
    window = random_window(seed, n, 0.1)
    factors = window.factors._replace(
        measured_information=np.zeros((n, 6, 6)), level_information=np.zeros((n, 3, 3))
    )
    nothing = np.zeros((n, 4, 4))
    blank = factors._replace(measured=nothing, mounts=nothing)
    for one, other in zip(
        Window(window.poses, window.scale, window.prior, factors).linearised(),
        Window(window.poses, window.scale, window.prior, blank).linearised(),
        strict=True,
    ):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("argument", range(12))
def test_windows_of_wrong_size_are_refused(argument: int) -> None:
    window = random_window(0, 3, 0.1)
    arrays = [window.poses, window.scale, *window.prior, *window.factors]
    _native.linearised(*arrays, CAUCHY_SCALE, 3)
    for wrong in (arrays[argument][:-1], arrays[argument][..., :-1], arrays[argument][None]):
        changed = [*arrays[:argument], wrong, *arrays[argument + 1 :]]
        with pytest.raises((ValueError, TypeError)):
            _native.linearised(*changed, CAUCHY_SCALE, 3)


def test_invalid_counts_and_kernels_are_refused() -> None:
    window = random_window(0, 3, 0.1)
    arrays = [window.poses, window.scale, *window.prior, *window.factors]
    with pytest.raises(ValueError, match="count"):
        _native.linearised(*arrays, CAUCHY_SCALE, 4)
    with pytest.raises(ValueError, match="kernel"):
        _native.linearised(*arrays, np.nan, 3)
    with pytest.raises(ValueError, match="poses"):
        _native.linearised(np.empty((0, 4, 4)), *arrays[1:], CAUCHY_SCALE, 0)


def test_invalid_equations_and_steps_are_refused() -> None:
    with pytest.raises(ValueError, match="variable"):
        _native.solved(np.eye(3), np.ones(4), 1)
    with pytest.raises(ValueError, match="variable"):
        _native.solved(np.ones((3, 2)), np.ones(3), 1)
    with pytest.raises(ValueError, match="count"):
        _native.solved(np.eye(3), np.ones(3), 4)
    with pytest.raises(ValueError, match="singular"):
        _native.solved(np.ones((2, 2)), np.ones(2), 1)
    with pytest.raises(ValueError, match="change"):
        _native.moved(np.zeros((2, 4, 4)), np.zeros((3, 6)))


def test_values_that_are_not_finite_pass_through() -> None:
    window = random_window(0, 3, 0.1)
    window.poses[1, 0, 3] = np.nan
    step, _ = window.gauss_newton_step()
    assert np.isnan(step).any()
