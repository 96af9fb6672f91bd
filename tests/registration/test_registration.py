"""Registration of scans to the surface map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform
from scipy.stats import multivariate_normal
from tracking_world import SHORT, bare_wall, short_drive, true_camera

from circumspect.errors import InputError
from circumspect.geometry import se3
from circumspect.registration import (
    PointToPlaneProblem,
    RegistrationSettings,
    Scan,
    ScanSurface,
    SurfaceMap,
    register,
)
from circumspect.registration.point_to_plane import RIDGE_INFORMATION, SPURIOUS_FACTOR
from circumspect.sensing import RgbdFrame

LOOSE = np.diag([1e3] * 3 + [1e3] * 3)
"""About 2° and 3 cm."""


@pytest.fixture(scope="module")
def surface_map() -> SurfaceMap:
    T_map_camera = true_camera(float(SHORT[0]))
    surface = ScanSurface.from_scan(Scan.from_frame(short_drive()[0]))
    return SurfaceMap().with_surface(
        surface.with_vertical_floor_normals(T_map_camera), T_map_camera
    )


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_spurious_information_is_subtracted_per_direction(seed: int, rank: int) -> None:
    """The same by Cholesky's factor and a plain inverse."""
    rng = np.random.default_rng(seed)
    A, B = rng.normal(size=(6, rank)), rng.normal(size=(6, 6))
    H, spurious, g = 1e4 * A @ A.T, 1e2 * B @ B.T, rng.normal(size=6)
    problem = PointToPlaneProblem(hessian=H, spurious=spurious, gradient=H @ g)
    found = problem.without_spurious_information()
    L = np.linalg.cholesky(spurious + RIDGE_INFORMATION * np.eye(6))
    values, U = np.linalg.eigh(np.linalg.inv(L) @ H @ np.linalg.inv(L).T)
    kept = np.maximum(values - SPURIOUS_FACTOR, 0)
    hessian = L @ U @ np.diag(kept) @ U.T @ L.T
    np.testing.assert_allclose(found.hessian, hessian, rtol=0, atol=1e-7 * np.abs(H).max())
    fraction = np.diag(kept / np.maximum(values, SPURIOUS_FACTOR))
    gradient = L @ U @ fraction @ U.T @ np.linalg.inv(L) @ H @ g
    np.testing.assert_allclose(found.gradient, gradient, rtol=0, atol=1e-7 * np.abs(H @ g).max())


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_evidence_of_a_linear_problem_is_exact(surface_map: SurfaceMap, seed: int) -> None:
    """The density of the innovation, times what depends on the scan alone."""
    rng = np.random.default_rng(seed)
    A, B = rng.normal(size=(2, 6, 6))
    H, prior, off = A @ A.T + np.eye(6), B @ B.T + np.eye(6), rng.normal(size=6)
    optimum = np.linalg.solve(prior + H, H @ off)
    found = replace(
        register(Scan.from_frame(short_drive()[1]), surface_map, true_camera(0.0), LOOSE),
        hessian=H, information=prior + H, innovation=optimum, gradient=-prior @ optimum,
    )  # fmt: skip
    covariance = np.linalg.inv(prior) + np.linalg.inv(H)
    density = multivariate_normal(np.zeros(6), covariance).logpdf(off)
    of_scan = (np.linalg.slogdet(H)[1] - 6 * np.log(2 * np.pi)) / 2
    evidence = found.log_occam_factor() - found.squared_innovation() / 2
    assert evidence == pytest.approx(density - of_scan)


def test_vaguer_prior_pays_more(surface_map: SurfaceMap) -> None:
    true, scan = true_camera(float(SHORT[1])), Scan.from_frame(short_drive()[1])
    factors = [
        register(scan, surface_map, true, certainty * LOOSE).log_occam_factor()
        for certainty in (0.01, 1.0, 1e9)
    ]
    assert factors[0] < factors[1] - 10 < factors[2] - 20
    # A scan without information adds no cost.
    nothing = register(scan.subsampled(len(scan)), surface_map, true, LOOSE)
    assert nothing.log_occam_factor() == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("number", [1, 2, 4])
def test_known_motion_is_recovered(surface_map: SurfaceMap, number: int) -> None:
    true = true_camera(float(SHORT[number]))
    off = se3.exp(np.array([0.01, -0.012, 0.008, 0.02, -0.015, 0.01]))
    found = register(Scan.from_frame(short_drive()[number]), surface_map, true * off, LOOSE)
    error = se3.log(true.inv() * found.T_map_camera)
    assert found.converged
    assert np.linalg.norm(error[:3]) < np.radians(0.4)
    assert np.linalg.norm(error[3:]) < 0.010
    assert found.overlap > 0.8
    assert found.residual < 0.006


@pytest.mark.parametrize("shift", [0.0, 0.004, -0.008])
def test_result_does_not_depend_on_the_start(surface_map: SurfaceMap, shift: float) -> None:
    """Within the basin of convergence the prior is where it was given."""
    prior = true_camera(float(SHORT[1]))
    scan = Scan.from_frame(short_drive()[1])
    start = prior * se3.exp(np.full(6, shift))
    expected = register(scan, surface_map, prior, LOOSE)
    found = register(scan, surface_map, prior, LOOSE, T_map_start=start)
    assert found.converged
    between = se3.log(expected.T_map_camera.inv() * found.T_map_camera)
    np.testing.assert_allclose(between, 0, atol=5e-4)
    np.testing.assert_allclose(
        found.innovation, se3.log(prior.inv() * found.T_map_camera), atol=1e-9
    )


def test_result_moves_with_map_and_prior(surface_map: SurfaceMap) -> None:
    """A common rigid motion of map and prior moves the result, up to the map's voxels."""
    scan, G = Scan.from_frame(short_drive()[2]), se3.exp([0.0, 0.0, 0.8, 1.0, -2.0, 0.0])
    start = true_camera(float(SHORT[2])) * se3.exp([0, 0, 0.005, 0.01, 0, 0])
    one = register(scan, surface_map, start, LOOSE)
    surface = ScanSurface.from_scan(Scan.from_frame(short_drive()[0]))
    T_map_moved = G * true_camera(float(SHORT[0]))
    moved = SurfaceMap().with_surface(surface.with_vertical_floor_normals(T_map_moved), T_map_moved)
    other = register(scan, moved, G * start, LOOSE)
    assert np.abs(se3.log((G * one.T_map_camera).inv() * other.T_map_camera)).max() < 6e-3
    np.testing.assert_allclose(
        np.linalg.eigvalsh(one.hessian), np.linalg.eigvalsh(other.hessian), rtol=0.15
    )


def test_directions_that_a_floor_does_not_constrain_stay_at_the_prior() -> None:
    """With only a plane in view, it determines height, roll and pitch."""
    camera = short_drive()[0].camera
    down = RigidTransform.from_matrix(
        [[1, 0, 0, 0.0], [0, -1, 0, 0.0], [0, 0, -1, 1.0], [0, 0, 0, 1.0]]
    )
    scan = Scan.from_frame(RgbdFrame(np.ones((camera.height, camera.width)), camera, 0.0))
    floor = SurfaceMap().with_surface(ScanSurface.from_scan(scan), down)
    off = se3.exp([0.02, 0.0, 0.0, 0.01, 0.02, 0.03])
    found = register(scan, floor, down * off, LOOSE)
    height, position = found.T_map_camera.translation[2], found.T_map_camera.translation[:2]
    assert abs(height - 1.0) < 0.002
    np.testing.assert_allclose(position, (down * off).translation[:2], atol=0.01)
    assert np.linalg.eigvalsh(found.hessian)[0] < 0.01


def test_scan_without_correspondences_stays_at_the_prior(surface_map: SurfaceMap) -> None:
    away = RigidTransform.from_translation([50.0, 0.0, 0.0])
    for target in (surface_map, SurfaceMap()):
        found = register(Scan.from_frame(short_drive()[0]), target, away, LOOSE)
        assert (found.converged, found.inliers) == (False, 0)
        assert found.T_map_camera is away


def test_frame_of_nan_is_an_empty_scan(surface_map: SurfaceMap) -> None:
    frame = short_drive()[0]
    empty = Scan.from_frame(RgbdFrame(np.full(frame.depth.shape, np.nan), frame.camera, 0.0))
    assert len(empty) == 0
    assert ScanSurface.from_scan(empty).normals_xyz.shape == (0, 3)
    assert not register(empty, surface_map, RigidTransform.identity(), LOOSE).converged


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_prior_determines_the_pose_along_a_bare_wall(seed: int) -> None:
    """Noise of the normals acts like a texture. It must not hold the camera."""
    rng = np.random.default_rng(seed)
    surface = ScanSurface.from_scan(bare_wall(rng))
    wall = SurfaceMap().with_surface(surface, RigidTransform.identity())
    prior = RigidTransform.from_translation([0.02, -0.01, 0.01])
    sigmas = np.array([np.radians(1.0)] * 3 + [0.02] * 3)
    found = register(bare_wall(rng), wall, prior, np.diag(sigmas**-2.0))
    x, y, z = found.T_map_camera.translation
    assert abs(z) < 3e-3, "the wall determines the distance to it"
    assert (x, y) == pytest.approx((0.02, -0.01), abs=4e-3)
    along = np.linalg.inv(found.information)[3:5, 3:5]
    assert (np.sqrt(np.diag(along)) > 0.7 * 0.02).all()


def test_rough_rim_does_not_determine_the_pose_along_a_bare_wall() -> None:
    """The normal of a rim mixes both of its sides and pulls along the wall."""
    rng = np.random.default_rng(1)
    prior = np.diag(np.array([np.radians(0.2)] * 3 + [0.01] * 3) ** -2.0)
    surface, again = ScanSurface.from_scan(bare_wall(rng)), bare_wall(rng)
    # Both have a rim at the same place, 8 mm apart, with a normal along the wall.
    rim = np.column_stack([np.zeros(12), np.linspace(-0.5, 0.5, 12), np.full(12, 1.4)])
    scan = Scan.with_white_noise(
        np.vstack([again.points_xyz, rim + np.array([0.008, 0, 0])]),
        np.append(again.sigmas, [2e-3] * 12),
    )
    normals = np.tile([-0.9, 0.0, -np.sqrt(0.19)], (12, 1))

    def shift(roughness: float) -> float:
        known = ScanSurface(
            Scan.with_white_noise(np.vstack([surface.scan.points_xyz, rim]), scan.sigmas),
            np.vstack([surface.normals_xyz, normals]),
            np.append(surface.normal_variances, [1e-3] * 12),
            np.append(surface.roughness, [roughness] * 12),
        )
        wall = SurfaceMap().with_surface(known, RigidTransform.identity())
        found = register(scan, wall, RigidTransform.identity(), prior)
        return abs(float(found.T_map_camera.translation[0]))

    assert shift(0.0) > 1.5e-3
    assert shift(0.01**2) < 0.5e-3


def test_back_of_a_board_does_not_match_its_front() -> None:
    """The back of a board of 4 cm is in the map and its front in view, within `max_distance`."""
    rng = np.random.default_rng(0)
    turn = se3.exp([0, np.pi, 0, 0, 0, 0])
    behind = RigidTransform.from_translation([0.0, 0.0, 3.04]) * turn
    back = SurfaceMap().with_surface(ScanSurface.from_scan(bare_wall(rng)), behind)
    np.testing.assert_allclose(np.median(back.points_xyz[:, 2]), 1.54, atol=2e-3)
    loose = np.diag(np.array([0.1] * 6) ** -2.0)
    found = register(bare_wall(rng), back, RigidTransform.identity(), loose)
    assert found.inliers == 0
    np.testing.assert_allclose(found.T_map_camera.translation, 0, atol=1e-12)


@pytest.mark.parametrize("max_distance", [0.0, -1.0, 11.0, np.nan])
def test_invalid_correspondence_distances_are_refused(max_distance: float) -> None:
    with pytest.raises(InputError, match="max_distance must lie in"):
        RegistrationSettings(max_distance=max_distance)
