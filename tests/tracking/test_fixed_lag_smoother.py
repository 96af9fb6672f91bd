"""The window's estimate against truth, against the whole history, and against numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2

from circumspect.geometry import se3_matrices
from circumspect.motion import RelativeMotion
from circumspect.tracking import fixed_lag_smoother, smoother_window
from circumspect.tracking.fixed_lag_smoother import (
    UNMEASURED,
    FixedLagSmoother,
    LevelFactor,
    PoseFactor,
)

STEP = np.array([0.0, 0.0, 0.05, 0.0, 0.0, 0.05])
ODOMETRY = np.array([0.002] * 3 + [0.004] * 3)
SCAN = np.array([0.003] * 6)
SLIP = 0.95
START = np.eye(6) * 1e-8
MOUNT = np.eye(4)


def drive(
    seed: int,
    frames: int = 40,
    unmeasured: range = range(0),
    outlier: int | None = None,
    level: LevelFactor | None = None,
) -> tuple[list[NDArray[np.float64]], list[FixedLagSmoother]]:
    """A camera on an arc whose wheels slip by 5 %: true poses and estimates."""
    rng = np.random.default_rng(seed)
    true, smoother = np.eye(4), FixedLagSmoother.from_pose(np.eye(4), START, 0.05)
    truth, estimates = [], []
    by_scale = np.zeros((6, 2))
    by_scale[5, 0] = STEP[5] / SLIP
    for frame in range(frames):
        true = true @ se3_matrices.exp(STEP)
        reported = STEP + rng.normal(size=6) * ODOMETRY
        reported[5] += STEP[5] / SLIP - STEP[5]
        if frame == outlier:
            reported[3:] += 1.0
        odometry = RelativeMotion(se3_matrices.exp(reported), by_scale, np.diag(ODOMETRY**2.0))
        scan = PoseFactor(true @ se3_matrices.exp(rng.normal(size=6) * SCAN), np.diag(SCAN**-2.0))
        if frame in unmeasured:
            scan = UNMEASURED
        start = smoother.predicted(odometry).T_map_camera
        if scan is not UNMEASURED:
            start = scan.T_map_camera
        smoother = smoother.extended(odometry, start, scan, level)
        truth.append(true)
        estimates.append(smoother)
    return truth, estimates


def error(true: NDArray[np.float64], smoother: FixedLagSmoother) -> NDArray[np.float64]:
    return se3_matrices.log(se3_matrices.inverse(true) @ smoother.T_map_camera)


def test_errors_are_consistent_with_the_covariance() -> None:
    """The normalised squared errors of independent drives are chi-squared distributed."""
    squares = []
    for seed in range(40):
        truth, estimates = drive(seed, frames=25, unmeasured=range(10, 16))
        for frame in (8, 14, 24):
            e = error(truth[frame], estimates[frame])
            squares.append(e @ np.linalg.solve(estimates[frame].covariance[:6, :6], e))
    low, high = chi2(6 * len(squares)).ppf([0.001, 0.999]) / len(squares)
    assert low < np.mean(squares) < high


def test_the_scale_of_slipping_wheels_is_learnt() -> None:
    _, estimates = drive(0, frames=100)
    sigma = np.sqrt(estimates[-1].covariance[6, 6])
    assert estimates[-1].scale[0] == pytest.approx(SLIP, abs=3 * sigma)
    assert sigma < 0.012
    # The other scale has no measurement.
    assert estimates[-1].scale[1] == pytest.approx(1.0)
    assert estimates[-1].covariance[7, 7] == pytest.approx(0.05**2)


def test_a_short_window_loses_nothing_of_the_past(monkeypatch: pytest.MonkeyPatch) -> None:
    """The prior stands for all that left the window, up to its linearisation."""
    monkeypatch.setattr(smoother_window, "SCALE_DRIFT", 0.0)
    _, short = drive(1)
    monkeypatch.setattr(fixed_lag_smoother, "LAG", 1000)
    _, whole = drive(1)
    assert len(short[-1].window.poses) == 15
    assert len(whole[-1].window.poses) == 41
    np.testing.assert_allclose(short[-1].T_map_camera, whole[-1].T_map_camera, atol=2e-4)
    np.testing.assert_allclose(short[-1].covariance, whole[-1].covariance, rtol=0.02, atol=1e-8)


def test_a_measurement_corrects_the_poses_before_it() -> None:
    """Dead-reckoned poses in the window improve once a scan fits again."""
    before, after = [], []
    for seed in range(10):
        truth, estimates = drive(seed, frames=22, unmeasured=range(10, 20))
        last = estimates[19]
        smoothed = estimates[21].window.poses[-3]
        before.append(np.linalg.norm(error(truth[19], last)[3:]))
        gap = se3_matrices.log(se3_matrices.inverse(truth[19]) @ smoothed)
        after.append(np.linalg.norm(gap[3:]))
    assert np.mean(after) < 0.5 * np.mean(before)


def test_an_odometry_jump_does_not_move_the_pose() -> None:
    truth, estimates = drive(2, outlier=20)
    assert np.linalg.norm(error(truth[20], estimates[20])[3:]) < 0.02


def test_a_direction_that_no_scan_measures_is_left_to_the_odometry() -> None:
    smoother = FixedLagSmoother.from_pose(np.eye(4), START, 0.05)
    odometry = RelativeMotion(np.eye(4), np.zeros((6, 2)), np.diag(ODOMETRY**2.0))
    blind = np.diag([1e6, 1e6, 1e6, 0.0, 1e6, 1e6])
    there = se3_matrices.exp(np.array([0.0, 0.0, 0.0, 0.1, 0.002, 0.0]))
    moved = smoother.extended(odometry, np.eye(4), PoseFactor(there, blind))
    assert moved.T_map_camera[0, 3] == pytest.approx(0.0, abs=1e-6)
    assert moved.T_map_camera[1, 3] == pytest.approx(0.002, abs=2e-4)
    assert moved.covariance[3, 3] == pytest.approx(ODOMETRY[3] ** 2, rel=0.01)


def test_a_level_base_bounds_roll_pitch_and_height() -> None:
    level = LevelFactor(MOUNT, np.diag([1e6, 1e6, 1e6]))
    _, free = drive(3, unmeasured=range(40))
    _, held = drive(3, unmeasured=range(40), level=level)
    roll_pitch_height = [0, 1, 5]
    bound = np.sqrt(np.diag(held[-1].covariance)[roll_pitch_height])
    assert (bound < 0.0011).all()
    assert (np.sqrt(np.diag(free[-1].covariance)[roll_pitch_height]) > 0.01).all()


def test_the_gradient_is_the_derivative_of_the_cost() -> None:
    level = LevelFactor(MOUNT, np.diag([1e4, 1e4, 1e4]))
    _, estimates = drive(4, level=level)
    window = estimates[-1].window
    rng = np.random.default_rng(0)
    window = window.moved(rng.normal(size=92) * 1e-3)
    # The kernel's weights are constants of the linearisation; weak factors make them one.
    factors = window.factors
    factors = factors._replace(
        motion_information=factors.motion_information * 1e-6,
        measured_information=factors.measured_information * 1e-6,
    )
    window = replace(window, factors=factors)
    _, gradient = window.linearised()
    for column in (0, 4, 50, 88, 90, 91):
        step = np.zeros(92)
        step[column] = 1e-5
        slope = (_cost(window.moved(step)) - _cost(window.moved(-step))) / 2e-5
        assert gradient[column] == pytest.approx(slope, rel=1e-3, abs=1e-5), column


def _cost(window: smoother_window.Window) -> float:
    """Half the sum of squares, factor by factor."""
    inverse, log = se3_matrices.inverse, se3_matrices.log
    poses, prior, factors = window.poses, window.prior, window.factors
    change = log(inverse(prior.T_map_camera) @ poses[0])
    errors = [(np.concatenate([change, window.scale - prior.scale]), prior.information)]
    for k, T in enumerate(factors.motions):
        expected = T @ se3_matrices.exp(factors.by_scale[k] @ (window.scale - 1))
        error = log(inverse(expected) @ inverse(poses[k]) @ poses[k + 1])
        errors.append((error, factors.motion_information[k]))
    for k, T in enumerate(poses):
        errors.append((log(inverse(factors.measured[k]) @ T), factors.measured_information[k]))
        base = T @ inverse(factors.mounts[k])
        level = np.array([base[2, 1], -base[2, 0], base[2, 3]])
        errors.append((level, factors.level_information[k]))
    return float(sum(0.5 * e @ omega @ e for e, omega in errors))
