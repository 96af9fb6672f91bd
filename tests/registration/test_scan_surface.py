"""Normals of scans and their variances."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3
from circumspect.registration import Scan, ScanSurface
from circumspect.registration.scan_surface import NORMAL_NEIGHBOURS

SPACING = 0.03


def sheet(rng: np.random.Generator, noise: float, side: int = 30) -> Scan:
    """A plane 2 m ahead that faces the camera, one point in each square of 3 cm, with noise."""
    u, v = np.meshgrid(np.arange(side), np.arange(side))
    flat = SPACING * (
        np.stack([u.ravel(), v.ravel()], 1) - side / 2 + rng.uniform(0, 1, (side**2, 2))
    )
    depth = 2.0 + rng.normal(0, noise, side**2)
    return Scan.with_white_noise(np.column_stack([flat, depth]), np.full(side**2, noise))


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-3, 3e-3]))
def test_normals_vary_by_their_variance(seed: int, noise: float) -> None:
    surface = ScanSurface.from_scan(sheet(np.random.default_rng(seed), noise))
    inside = (np.abs(surface.scan.points_xyz[:, :2]) < 0.3).all(axis=1)
    x, y, z = surface.normals_xyz[inside].T
    assert (z < 0).all(), "towards the camera"
    found = 0.5 * ((x / z) ** 2 + (y / z) ** 2).mean()
    assert found == pytest.approx(surface.normal_variances[inside].mean(), rel=0.5)


def test_normals_near_an_edge_have_a_larger_variance() -> None:
    scan = sheet(np.random.default_rng(0), 1e-3)
    bent = scan.points_xyz.copy()
    bent[:, 2] += np.maximum(bent[:, 0], 0)
    surface = ScanSurface.from_scan(Scan.with_white_noise(bent, scan.sigmas))
    flat, edge = (np.abs(bent[:, 0]) > 0.15), (np.abs(bent[:, 0]) < 0.02)
    assert np.median(surface.normal_variances[edge]) > 6 * np.median(surface.normal_variances[flat])
    # The roughness of a flat part is the noise of its points.
    inside = flat & (np.abs(bent[:, :2]) < 0.35).all(axis=1)
    assert np.mean(surface.roughness[inside]) == pytest.approx(1e-3**2, rel=0.4)
    assert np.median(surface.roughness[edge]) > 10 * 1e-3**2


def test_scan_with_too_few_points_has_no_normals() -> None:
    few = Scan.with_white_noise(
        np.random.default_rng(0).normal(size=(NORMAL_NEIGHBOURS - 1, 3)),
        np.full(NORMAL_NEIGHBOURS - 1, 1e-3),
    )
    surface = ScanSurface.from_scan(few)
    assert not surface.normals_xyz.any()
    assert (surface.normal_variances > 0).all()


def test_only_floor_gets_vertical_normals() -> None:
    rng = np.random.default_rng(0)
    sheet_xyz = sheet(rng, 2e-3).points_xyz - [0, 0, 2.0]
    floor, wall = sheet_xyz, sheet_xyz[:, [2, 0, 1]] + [0.6, 0.0, 0.6]
    T_map_camera = se3.exp([np.radians(130), 0, 0, 0, 0, 0])
    T_map_camera = RigidTransform.from_translation([0.0, -1.0, 1.2]) * T_map_camera
    points = T_map_camera.inv().apply(np.vstack([floor, wall]))
    surface = ScanSurface.from_scan(
        Scan.with_white_noise(points, np.full(len(points), 2e-3))
    ).with_vertical_floor_normals(T_map_camera)
    up = T_map_camera.as_matrix()[:3, :3] @ surface.normals_xyz.T
    level = surface.normal_variances == 0
    assert level[: len(floor)].mean() > 0.9
    assert not level[len(floor) :].any()
    np.testing.assert_allclose(
        up[:, level], np.array([[0.0], [0.0], [1.0]]) * np.ones(level.sum()), atol=1e-12
    )
