from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform
from tracking_world import SHORT, short_drive, true_camera

from circumspect.errors import InputError
from circumspect.geometry import se3
from circumspect.mapping.gate import GateSettings, squared_distance, weakest_direction
from circumspect.mapping.linear_fit import FEIGNED, RIDGE, LinearFit
from circumspect.mapping.registration import RegistrationSettings, register
from circumspect.mapping.relocalisation import coarsely_aligned
from circumspect.mapping.scan import Scan
from circumspect.mapping.scan_surface import ScanSurface
from circumspect.mapping.scene_map import SceneMap
from circumspect.sensing import RgbdFrame

LOOSE = np.diag([1e3] * 3 + [1e3] * 3)
"""About 2° and 3 cm."""


@pytest.fixture(scope="module")
def scene() -> SceneMap:
    scan = Scan.of(short_drive()[0])
    T_map_camera = true_camera(float(SHORT[0]))
    surface = ScanSurface.of(scan).on_level_floor(T_map_camera)
    return SceneMap().with_surface(surface, T_map_camera)


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_what_noise_feigns_is_taken_off_direction_by_direction(seed: int, rank: int) -> None:
    """The same by Cholesky's factor and a plain inverse."""
    rng = np.random.default_rng(seed)
    A, B = rng.normal(size=(6, rank)), rng.normal(size=(6, 6))
    H, feigned, g = 1e4 * A @ A.T, 1e2 * B @ B.T, rng.normal(size=6)
    told = LinearFit(hessian=H, feigned=feigned, gradient=H @ g).believable()
    L = np.linalg.cholesky(feigned + RIDGE * np.eye(6))
    values, U = np.linalg.eigh(np.linalg.inv(L) @ H @ np.linalg.inv(L).T)
    kept = np.maximum(values - FEIGNED, 0)
    hessian = L @ U @ np.diag(kept) @ U.T @ L.T
    np.testing.assert_allclose(told.hessian, hessian, rtol=0, atol=1e-7 * np.abs(H).max())
    share = np.diag(kept / np.maximum(values, FEIGNED))
    gradient = L @ U @ share @ U.T @ np.linalg.inv(L) @ H @ g
    np.testing.assert_allclose(told.gradient, gradient, rtol=0, atol=1e-7 * np.abs(H @ g).max())


@pytest.mark.parametrize("number", [1, 2, 4])
def test_a_known_motion_is_recovered(scene: SceneMap, number: int) -> None:
    true = true_camera(float(SHORT[number]))
    off = se3.exp(np.array([0.01, -0.012, 0.008, 0.02, -0.015, 0.01]))
    found = register(Scan.of(short_drive()[number]), scene, true * off, LOOSE)
    error = se3.log(true.inv() * found.T_map_camera)
    assert found.converged
    assert np.linalg.norm(error[:3]) < np.radians(0.4)
    assert np.linalg.norm(error[3:]) < 0.010
    assert found.overlap > 0.8
    assert found.residual < 0.006


def test_the_optimum_moves_with_the_scene(scene: SceneMap) -> None:
    """A common rigid motion of scene and prior moves the result, up to the map's voxels."""
    scan, G = Scan.of(short_drive()[2]), se3.exp([0.0, 0.0, 0.8, 1.0, -2.0, 0.0])
    first = short_drive()[0]
    start = true_camera(float(SHORT[2])) * se3.exp([0, 0, 0.005, 0.01, 0, 0])
    one = register(scan, scene, start, LOOSE)
    kept = Scan.of(first)
    T_map_moved = G * true_camera(float(SHORT[0]))
    moved = SceneMap().with_surface(ScanSurface.of(kept).on_level_floor(T_map_moved), T_map_moved)
    other = register(scan, moved, G * start, LOOSE)
    assert np.abs(se3.log((G * one.T_map_camera).inv() * other.T_map_camera)).max() < 6e-3
    np.testing.assert_allclose(
        np.linalg.eigvalsh(one.hessian), np.linalg.eigvalsh(other.hessian), rtol=0.15
    )


def test_what_a_floor_does_not_hold_stays_as_the_prior_says() -> None:
    """Only a plane in view: height, roll and pitch come from it, the rest from the prior."""
    camera = short_drive()[0].camera
    down = RigidTransform.from_matrix(
        [[1, 0, 0, 0.0], [0, -1, 0, 0.0], [0, 0, -1, 1.0], [0, 0, 0, 1.0]]
    )
    frame = RgbdFrame(np.ones((camera.height, camera.width)), camera, 0.0)
    scan = Scan.of(frame)
    scene = SceneMap().with_surface(ScanSurface.of(scan), down)
    off = se3.exp([0.02, 0.0, 0.0, 0.01, 0.02, 0.03])
    found = register(scan, scene, down * off, LOOSE)
    height, place = found.T_map_camera.translation[2], found.T_map_camera.translation[:2]
    assert abs(height - 1.0) < 0.002
    np.testing.assert_allclose(place, (down * off).translation[:2], atol=0.01)
    assert weakest_direction(found.hessian) > 10
    assert GateSettings().verdict(found, LOOSE).reason == "the scene leaves one direction free"
    firmer = replace(found, hessian=np.diag([1e6] * 5 + [0.05**-2]))
    told = GateSettings().verdict(firmer, LOOSE).reason
    assert told == "the scene holds one direction to 0.050 m; 0.03 m are needed"
    assert np.isfinite(squared_distance(found, LOOSE))


def test_nothing_in_common_leaves_the_prior(scene: SceneMap) -> None:
    away = RigidTransform.from_translation([50.0, 0.0, 0.0])
    for scan, target in (
        (Scan.of(short_drive()[0]), scene),
        (Scan.of(short_drive()[0]), SceneMap()),
    ):
        found = register(scan, target, away, LOOSE)
        assert (found.converged, found.inliers) == (False, 0)
        assert found.T_map_camera is away


def test_a_frame_of_nan_is_an_empty_scan(scene: SceneMap) -> None:
    frame = short_drive()[0]
    nothing = Scan.of(RgbdFrame(np.full(frame.depth.shape, np.nan), frame.camera, 0.0))
    assert len(nothing) == 0
    assert ScanSurface.of(nothing).normals_xyz.shape == (0, 3)
    assert not register(nothing, scene, RigidTransform.identity(), LOOSE).converged


def test_coarse_alignment_reaches_further(scene: SceneMap) -> None:
    true, scan = true_camera(float(SHORT[0])), Scan.of(short_drive()[0])
    off = se3.exp([0.0, 0.0, 0.08, 0.08, 0.05, 0.0])
    found = coarsely_aligned(scan.points_xyz, scene.points_xyz, true * off)
    assert np.linalg.norm((true.inv() * found).translation) < 0.02


@pytest.mark.parametrize("points", [np.zeros(3), np.zeros((5, 2)), np.full((5, 3), np.nan)])
def test_points_that_small_gicp_would_misread_are_refused(points: np.ndarray) -> None:
    with pytest.raises(InputError, match="source points must be finite with shape"):
        coarsely_aligned(points, np.ones((9, 3)), RigidTransform.identity())


def wall(rng: np.random.Generator, noise: float = 2e-3) -> Scan:
    """A bare wall of 2 m by 1.2 m, 1.5 m ahead."""
    u, v = np.meshgrid(np.arange(66), np.arange(40))
    cells = np.stack([u.ravel(), v.ravel()], axis=1) - [33, 20]
    flat = 0.03 * (cells + rng.uniform(0, 1, cells.shape))
    depth = 1.5 + rng.normal(0, noise, len(flat))
    return Scan(np.column_stack([flat, depth]), np.full(len(flat), 2e-3))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_along_a_bare_wall_the_prior_decides(seed: int) -> None:
    """The normals' noise looks like a texture; it must not hold the camera."""
    rng = np.random.default_rng(seed)
    scene = SceneMap().with_surface(ScanSurface.of(wall(rng)), RigidTransform.identity())
    prior = RigidTransform.from_translation([0.02, -0.01, 0.01])
    sigmas = np.array([np.radians(1.0)] * 3 + [0.02] * 3)
    found = register(wall(rng), scene, prior, np.diag(sigmas**-2.0))
    x, y, z = found.T_map_camera.translation
    assert abs(z) < 3e-3, "the wall holds what lies across it"
    assert (x, y) == pytest.approx((0.02, -0.01), abs=4e-3)
    along = np.linalg.inv(found.information)[3:5, 3:5]
    assert (np.sqrt(np.diag(along)) > 0.7 * 0.02).all()
    assert not GateSettings().verdict(found, np.diag(sigmas**-2.0)).is_open


def test_an_uneven_rim_does_not_decide_along_a_bare_wall() -> None:
    """A rim's normal is of both its sides: it pulls along the wall, where nothing else holds."""
    rng = np.random.default_rng(1)
    prior = np.diag(np.array([np.radians(0.2)] * 3 + [0.01] * 3) ** -2.0)
    surface, again = ScanSurface.of(wall(rng)), wall(rng)
    # Both see a rim at the same place, 8 mm apart, with a normal that points along the wall.
    rim = np.column_stack([np.zeros(12), np.linspace(-0.5, 0.5, 12), np.full(12, 1.4)])
    seen = Scan(
        np.vstack([again.points_xyz, rim + np.array([0.008, 0, 0])]),
        np.append(again.sigmas, [2e-3] * 12),
    )
    normals = np.tile([-0.9, 0.0, -np.sqrt(0.19)], (12, 1))

    def pulled(unevenness: float) -> float:
        known = ScanSurface(
            Scan(np.vstack([surface.scan.points_xyz, rim]), seen.sigmas),
            np.vstack([surface.normals_xyz, normals]),
            np.append(surface.slopes, [1e-3] * 12),
            np.append(surface.unevenness, [unevenness] * 12),
        )
        scene = SceneMap().with_surface(known, RigidTransform.identity())
        found = register(seen, scene, RigidTransform.identity(), prior)
        return abs(float(found.T_map_camera.translation[0]))

    assert pulled(0.0) > 1.5e-3
    assert pulled(0.01**2) < 0.5e-3


def test_the_far_side_of_a_board_is_not_taken_for_the_near_one() -> None:
    """A board of 4 cm whose back is known, seen from the front: within reach, yet no match."""
    rng = np.random.default_rng(0)
    seen_from_behind = se3.exp([0, np.pi, 0, 0, 0, 0])
    behind = RigidTransform.from_translation([0.0, 0.0, 3.04]) * seen_from_behind
    scene = SceneMap().with_surface(ScanSurface.of(wall(rng)), behind)
    np.testing.assert_allclose(np.median(scene.points_xyz[:, 2]), 1.54, atol=2e-3)
    loose = np.diag(np.array([0.1] * 6) ** -2.0)
    found = register(wall(rng), scene, RigidTransform.identity(), loose)
    assert found.inliers == 0
    np.testing.assert_allclose(found.T_map_camera.translation, 0, atol=1e-12)


@pytest.mark.parametrize("reach", [0.0, -1.0, 11.0, np.nan])
def test_a_reach_that_no_search_can_take_is_refused(reach):
    with pytest.raises(InputError, match="the reach must lie in"):
        RegistrationSettings(reach=reach)
