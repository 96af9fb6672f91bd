"""Kernels of mapping and their NumPy twins agree."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracking_world import SHORT, short_drive, true_camera

from circumspect.geometry import se3, se3_matrices
from circumspect.mapping import _native
from circumspect.mapping import numpy_twin as twin
from circumspect.mapping.linear_fit import FEWEST, FINDING, TELLING, linearised
from circumspect.mapping.scan import Scan
from circumspect.mapping.scan_surface import ScanSurface
from circumspect.mapping.scene_map import SceneMap

seeds = st.integers(0, 2**32 - 1)
FIGURES = ("hessian", "feigned", "gradient", "inliers", "overlap", "distance", "residual", "misfit")


def random_scene(rng: np.random.Generator, count: int, spread: float) -> SceneMap:
    scan = Scan(rng.uniform(-spread, spread, (count, 3)), rng.uniform(1e-3, 5e-3, count))
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    unevenness = rng.uniform(0, 3e-3, count) ** 2
    surface = ScanSurface(scan, normals, rng.uniform(0, 0.01, count), unevenness)
    return SceneMap().with_surface(surface, se3.exp(np.zeros(6)))


def assert_same_fit(scan: Scan, scene: SceneMap, T: np.ndarray, reach: float) -> None:
    for weighing in (FINDING, TELLING):
        native, expected = (
            by(scan, scene, T, reach, weighing) for by in (linearised, twin.linearised)
        )
        for name in FIGURES:
            one, other = getattr(native, name), getattr(expected, name)
            scale = max(1e-9, float(np.abs(other).max()))
            np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-9 * scale, err_msg=name)


@settings(max_examples=40)
@given(seeds, st.sampled_from([0.02, 0.05, 0.13]), st.sampled_from([0.1, 0.5, 3.0]))
def test_the_linear_problem(seed: int, reach: float, spread: float) -> None:
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, int(rng.integers(0, 400)), spread)
    count = int(rng.integers(0, 300))
    scan = Scan(rng.uniform(-spread, spread, (count, 3)), rng.uniform(1e-3, 5e-3, count))
    assert_same_fit(scan, scene, se3_matrices.exp(rng.normal(0, 0.05, 6)), reach)


@pytest.mark.parametrize("step", [1, 3])
def test_the_linear_problem_of_real_pictures(step: int) -> None:
    first = Scan.of(short_drive()[0])
    scene = SceneMap().with_surface(ScanSurface.of(first), true_camera(float(SHORT[0])))
    T = true_camera(float(SHORT[1])).as_matrix() @ se3_matrices.exp(np.full(6, 0.004))
    scan = Scan.of(short_drive()[1]).thinned(step)
    assert linearised(scan, scene, T, 0.05).inliers > 100
    assert_same_fit(scan, scene, T, 0.05)


@given(seeds, st.integers(3, 12), st.sampled_from([1e-3, 1.0, 1e3]))
def test_plane_fits(seed: int, neighbours: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3)) * scale * [1.0, rng.uniform(0.1, 1), rng.uniform(0, 0.05)]
    near = rng.integers(0, 40, (25, neighbours))
    normals, variances = _native.plane_fits(points, near)
    expected_normals, expected = twin.plane_fits(points, near)
    np.testing.assert_allclose(variances, expected, atol=1e-12 * expected.max())
    clear = expected[:, 1] - expected[:, 0] > 1e-3 * expected[:, 2]
    cosines = np.einsum("ij,ij->i", normals, expected_normals)
    np.testing.assert_allclose(np.abs(cosines[clear]), 1, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)


def test_threads_change_no_plane() -> None:
    rng = np.random.default_rng(0)
    points, near = rng.normal(size=(40, 3)), rng.integers(0, 40, (2001, 8))
    alone = _native.plane_fits(points, near)
    for threads in (2, 3, 64):
        for one, other in zip(alone, _native.plane_fits(points, near, threads), strict=True):
            np.testing.assert_array_equal(one, other)
    np.testing.assert_allclose(alone[1], twin.plane_fits(points, near)[1], atol=1e-12)


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


@pytest.mark.parametrize("near", [[[0, 40]], [[-1, 0]], [[]]])
def test_neighbours_must_be_points(near) -> None:
    with pytest.raises(ValueError, match="neighbours"):
        _native.plane_fits(np.zeros((40, 3)), np.array(near, np.int64))


def test_points_that_are_nowhere_have_no_correspondence() -> None:
    scene = random_scene(np.random.default_rng(0), 200, 0.1)
    nowhere = np.full((FEWEST + 2, 3), np.nan)
    nowhere[0] = 1e300
    fit = linearised(Scan(nowhere, np.full(len(nowhere), 1e-3)), scene, np.eye(4), 0.05)
    assert fit.inliers == 0


@pytest.mark.parametrize(
    ("points", "normals", "uneven", "cell"),
    [
        (np.full((3, 3), np.inf), np.zeros((3, 3)), 3, 0.05),
        (np.zeros((3, 3)), np.zeros((2, 3)), 3, 0.05),
        (np.zeros((3, 3)), np.zeros((3, 3)), 2, 0.05),
        (np.zeros((3, 3)), np.zeros((3, 3)), 3, 0.0),
    ],
)
def test_planes_that_are_none_are_refused(points, normals, uneven, cell) -> None:
    with pytest.raises(ValueError, match=r"points|normal|cell"):
        _native.PlaneMap(points, normals, np.ones(3), np.zeros(3), np.zeros(uneven), cell)
