"""Kernels of registration agree with their NumPy references."""

from __future__ import annotations

import numpy as np
import pytest
import registration_reference
from hypothesis import given, settings
from hypothesis import strategies as st
from tracking_world import SHORT, short_drive, true_camera

from circumspect.geometry import se3, se3_matrices
from circumspect.registration import (
    Scan,
    ScanSurface,
    SurfaceMap,
    _native,
    linearised,
)
from circumspect.registration.point_to_plane import COARSE, FINE, MIN_CORRESPONDENCES

seeds = st.integers(0, 2**32 - 1)
FIGURES = (
    "hessian", "spurious", "gradient", "inliers", "overlap", "distance", "residual",
    "normalised_residual",
)  # fmt: skip


def random_map(rng: np.random.Generator, count: int, spread: float) -> SurfaceMap:
    scan = Scan.with_white_noise(
        rng.uniform(-spread, spread, (count, 3)), rng.uniform(1e-3, 5e-3, count)
    )
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    roughness = rng.uniform(0, 3e-3, count) ** 2
    surface = ScanSurface(scan, normals, rng.uniform(0, 0.01, count), roughness)
    return SurfaceMap().with_surface(surface, se3.exp(np.zeros(6)))


def assert_same_problem(
    scan: Scan, surface_map: SurfaceMap, T: np.ndarray, max_distance: float
) -> None:
    for weighting in (COARSE, FINE):
        native, expected = (
            linearise(scan, surface_map, T, max_distance, weighting)
            for linearise in (linearised, registration_reference.linearised)
        )
        for name in FIGURES:
            one, other = getattr(native, name), getattr(expected, name)
            scale = max(1e-9, float(np.abs(other).max()))
            np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-9 * scale, err_msg=name)


@settings(max_examples=40)
@given(seeds, st.sampled_from([0.02, 0.05, 0.13]), st.sampled_from([0.1, 0.5, 3.0]))
def test_linearised_agrees_for_random_scans(seed: int, max_distance: float, spread: float) -> None:
    rng = np.random.default_rng(seed)
    surface_map = random_map(rng, int(rng.integers(0, 400)), spread)
    count = int(rng.integers(0, 300))
    scan = Scan.with_white_noise(
        rng.uniform(-spread, spread, (count, 3)), rng.uniform(1e-3, 5e-3, count)
    )
    T = se3_matrices.exp(rng.normal(0, 0.05, 6))
    assert_same_problem(scan, surface_map, T, max_distance)


@pytest.mark.parametrize("step", [1, 3])
def test_linearised_agrees_for_simulated_frames(step: int) -> None:
    first = Scan.from_frame(short_drive()[0])
    surface_map = SurfaceMap().with_surface(
        ScanSurface.from_scan(first), true_camera(float(SHORT[0]))
    )
    T = true_camera(float(SHORT[1])).as_matrix() @ se3_matrices.exp(np.full(6, 0.004))
    scan = Scan.from_frame(short_drive()[1]).subsampled(step)
    assert linearised(scan, surface_map, T, 0.05).inliers > 100
    assert_same_problem(scan, surface_map, T, 0.05)


@given(seeds, st.integers(3, 12), st.sampled_from([1e-3, 1.0, 1e3]))
def test_plane_fits_agree(seed: int, count: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3)) * scale * [1.0, rng.uniform(0.1, 1), rng.uniform(0, 0.05)]
    neighbours = rng.integers(0, 40, (25, count))
    normals, variances = _native.plane_fits(points, neighbours)
    expected_normals, expected = registration_reference.plane_fits(points, neighbours)
    np.testing.assert_allclose(variances, expected, atol=1e-12 * expected.max())
    clear = expected[:, 1] - expected[:, 0] > 1e-3 * expected[:, 2]
    cosines = np.einsum("ij,ij->i", normals, expected_normals)
    np.testing.assert_allclose(np.abs(cosines[clear]), 1, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)


def test_plane_fits_do_not_depend_on_the_number_of_threads() -> None:
    rng = np.random.default_rng(0)
    points, neighbours = rng.normal(size=(40, 3)), rng.integers(0, 40, (2001, 8))
    alone = _native.plane_fits(points, neighbours)
    for threads in (2, 3, 64):
        for one, other in zip(alone, _native.plane_fits(points, neighbours, threads), strict=True):
            np.testing.assert_array_equal(one, other)
    _, expected = registration_reference.plane_fits(points, neighbours)
    np.testing.assert_allclose(alone[1], expected, atol=1e-12)


@pytest.mark.parametrize(
    ("points", "variances"),
    [
        (np.ones((4, 3)), [0.0, 0.0, 0.0]),
        (np.arange(4.0)[:, None] * [0.0, 2.0, 0.0], [0.0, 0.0, 5.0]),
        (np.array([[0, 0, 1.0], [1, 0, 1], [0, 1, 1], [1, 1, 1]]), [0.0, 0.25, 0.25]),
    ],
)
def test_plane_fits_of_a_point_a_line_and_a_square(points, variances) -> None:
    normals, found = _native.plane_fits(points, np.arange(4)[None])
    np.testing.assert_allclose(found[0], variances, atol=1e-15)
    np.testing.assert_allclose(normals[0] @ (points - points.mean(axis=0)).T, 0, atol=1e-12)


@pytest.mark.parametrize("neighbours", [[[0, 40]], [[-1, 0]], [[]]])
def test_neighbours_that_are_not_points_are_refused(neighbours) -> None:
    with pytest.raises(ValueError, match="neighbours"):
        _native.plane_fits(np.zeros((40, 3)), np.array(neighbours, np.int64))


def test_points_that_are_not_finite_have_no_correspondence() -> None:
    surface_map = random_map(np.random.default_rng(0), 200, 0.1)
    invalid = np.full((MIN_CORRESPONDENCES + 2, 3), np.nan)
    invalid[0] = 1e300
    problem = linearised(
        Scan.with_white_noise(invalid, np.full(len(invalid), 1e-3)), surface_map, np.eye(4), 0.05
    )
    assert problem.inliers == 0


@pytest.mark.parametrize(
    ("points", "normals", "count", "cell"),
    [
        (np.full((3, 3), np.inf), np.zeros((3, 3)), 3, 0.05),
        (np.zeros((3, 3)), np.zeros((2, 3)), 3, 0.05),
        (np.zeros((3, 3)), np.zeros((3, 3)), 2, 0.05),
        (np.zeros((3, 3)), np.zeros((3, 3)), 3, 0.0),
    ],
)
def test_invalid_planes_are_refused(points, normals, count, cell) -> None:
    with pytest.raises(ValueError, match=r"points|normal|cell"):
        _native.PlaneMap(points, normals, np.ones(3), np.zeros(3), np.zeros(count), cell)
