from __future__ import annotations

import numpy as np
import pytest
from ceiling_world import camera, lens
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PinholeCamera
from circumspect.localization import FixedCamera, LensCamera

PIXELS = st.tuples(st.floats(0, 1279), st.floats(0, 959))


@given(PIXELS)
def test_projection_inverts_rays(pixel):
    one = lens()
    ray = one.rays_xy(np.array([pixel]))
    again = one.project(2.7 * np.column_stack([ray, np.ones(1)]))
    np.testing.assert_allclose(again, [pixel], atol=1e-8)


def test_projection_equals_that_of_opencv():
    import cv2

    one = lens()
    points = np.random.default_rng(0).uniform([-1, -0.7, 2], [1, 0.7, 3], (50, 3))
    p = one.pinhole
    K = np.array([[p.fx, 0, p.cx], [0, p.fy, p.cy], [0, 0, 1]])
    theirs, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, np.array(one.distortion))
    np.testing.assert_allclose(one.project(points), theirs.reshape(-1, 2), atol=1e-9)


def test_jacobians_are_the_derivatives():
    one, points = lens(), np.array([[0.3, -0.4, 2.0], [-0.9, 0.5, 2.7]])
    step = 1e-6
    for axis in range(3):
        move = step * np.eye(3)[axis]
        numeric = (one.project(points + move) - one.project(points - move)) / (2 * step)
        np.testing.assert_allclose(one.projection_slopes(points)[:, :, axis], numeric, rtol=1e-6)


def test_points_behind_or_far_aside_are_not_projected():
    pixels = lens().project([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [50.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    assert np.isnan(pixels[:3]).all()
    assert np.isfinite(pixels[3]).all()


@pytest.mark.parametrize(
    "bend", [(-2.0, 0, 0, 0, 0), (np.nan, 0, 0, 0, 0), (0.1, 0.1), (0, 0, 5.0, 0, 0)]
)
def test_impossible_lenses_are_refused(bend):
    with pytest.raises(GeometryError, match="distortion"):
        LensCamera(PinholeCamera(640, 480, 400, 400, 320, 240), bend)


def test_rays_meet_the_plane_where_points_are_seen():
    one = camera(0.4, -0.3)
    places = np.random.default_rng(1).uniform(-1, 1, (20, 2))
    pixels = one.project(np.column_stack([places, np.full(20, 0.3)]))
    np.testing.assert_allclose(one.on_plane(pixels, 0.3), places, atol=1e-9)
    assert np.isnan(one.on_plane(pixels, 3.5)).all()
    outline = one.outline_xy(0.3)
    np.testing.assert_array_equal(outline[0], outline[-1])
    assert np.isfinite(outline).all()


@pytest.mark.parametrize("covariance", [np.eye(3), -np.eye(6), np.full((6, 6), np.nan)])
def test_a_camera_has_a_name_and_a_covariance(covariance):
    with pytest.raises(InputError, match="covariance"):
        camera(covariance=covariance)
    with pytest.raises(InputError, match="name"):
        FixedCamera("", lens(), camera().T_map_camera)
