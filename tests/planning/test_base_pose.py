from __future__ import annotations

import numpy as np
import pytest
from analytic_shapes import CAMERA, MOUNT, box, circle, facing_centre, planner_input, walls
from hypothesis import given
from hypothesis import strategies as st

from circumspect.planning import base_pose, camera_place, fitting_distance
from circumspect.planning.base_pose import (
    MAX_DISTANCE_M,
    MAX_IMAGE_FRACTION,
    MIN_DISTANCE_M,
    _fractions_outside,
    alternatives,
)
from circumspect.planning.planner_input import NextView

PLACE = st.tuples(st.floats(-3, 3), st.floats(-3, 3))


@given(camera=PLACE, towards=PLACE)
def test_the_camera_has_the_requested_place_and_view_direction(camera, towards) -> None:
    if np.hypot(camera[0] - towards[0], camera[1] - towards[1]) < 0.05:
        return
    base = base_pose(camera, towards, MOUNT)
    placed = camera_place(base, MOUNT)
    np.testing.assert_allclose(placed.xy, camera, atol=1e-9)
    direction = np.subtract(towards, camera) / np.linalg.norm(np.subtract(towards, camera))
    np.testing.assert_allclose(placed.heading_xy, direction, atol=1e-9)
    # The camera looks left: the object is on the left of the way forward.
    side = base.heading_xy[0] * direction[1] - base.heading_xy[1] * direction[0]
    assert side == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("size", [0.3, 0.8, 1.4])
def test_a_low_object_fits_the_image_at_the_fitting_distance(size) -> None:
    points = walls(box(size, size).outline_xy)
    away = fitting_distance(planner_input(points, facing_centre(0, 2)), np.array([1.0, 0.0]))
    base = base_pose((size / 2 + away, 0.0), (0.0, 0.0), MOUNT)
    pixels = CAMERA.project((base.as_transform() * MOUNT).inv().apply(points))
    inside = (pixels >= 0).all(axis=1) & (pixels < [CAMERA.width, CAMERA.height]).all(axis=1)
    assert inside.mean() > 0.97
    assert away >= 0.8


def test_the_fitting_distance_grows_with_the_object_up_to_the_range() -> None:
    side = np.array([0.0, 1.0])
    found = [
        fitting_distance(planner_input(walls(circle(r).outline_xy), facing_centre(0, 3)), side)
        for r in (0.2, 0.5, 0.9, 4.0)
    ]
    assert found[0] == pytest.approx(0.8, abs=0.11)
    assert found[0] <= found[1] < found[2]
    assert found[3] <= 3.5


def test_a_longer_range_allows_a_larger_distance() -> None:
    large, side = walls(circle(1.5).outline_xy), np.array([0.0, 1.0])
    found = [
        fitting_distance(planner_input(large, facing_centre(0, 6), depth_range=(0.3, most)), side)
        for most in (1.5, 3.0, 6.0, np.inf)
    ]
    assert found[0] < found[1] < found[2]
    assert found[2] <= found[3] <= MAX_DISTANCE_M
    assert found[0] <= 1.5


def test_the_minimum_range_is_kept() -> None:
    post = walls(circle(0.1).outline_xy)
    near, far = (
        fitting_distance(
            planner_input(post, facing_centre(0, 3), depth_range=(nearest, 5.0)),
            np.array([0.0, 1.0]),
        )
        for nearest in (0.3, 1.6)
    )
    assert near < 1.1
    assert far > near + 0.4


@given(azimuth=st.floats(0, 2 * np.pi), wide=st.floats(0.2, 3.0), deep=st.floats(0.2, 3.0))
def test_misses_of_all_distances_equal_those_of_each(azimuth, wide, deep) -> None:
    """Fast against slow: a camera put to every distance, one after the other."""
    around = planner_input(walls(box(wide, deep).outline_xy), facing_centre(0, 3))
    outward, away = np.array([np.cos(azimuth), np.sin(azimuth)]), np.arange(0.8, 4.0, 0.1)
    centre = np.array([0.3, -0.2])
    found = _fractions_outside(around, around.points_xyz, centre, away, outward)
    for number, distance in enumerate(away):
        base = base_pose(centre + distance * outward, centre, MOUNT)
        x, y, z = (base.as_transform() * MOUNT).inv().apply(around.points_xyz).T
        inside = (z >= around.depth_range[0]) & (z <= around.depth_range[1])
        with np.errstate(divide="ignore", invalid="ignore"):
            inside &= np.abs(CAMERA.fx * x / z) <= MAX_IMAGE_FRACTION * CAMERA.width / 2
            inside &= np.abs(CAMERA.fy * y / z) <= MAX_IMAGE_FRACTION * CAMERA.height / 2
        assert found[number] == pytest.approx(1 - inside.mean(), abs=1e-12)


def test_alternatives_look_at_the_same_place_from_the_same_side() -> None:
    view = NextView(facing_centre(0.7, 1.0), (0.0, 0.0), None, "wanted")
    found = list(alternatives(view, MOUNT))
    assert len(found) >= 4
    wanted = camera_place(view.T_map_base, MOUNT)
    for other in found:
        eye = camera_place(other.T_map_base, MOUNT)
        assert eye.yaw == pytest.approx(wanted.yaw)
        assert np.linalg.norm(eye.xy) >= MIN_DISTANCE_M - 1e-9
        np.testing.assert_allclose(
            eye.xy / np.linalg.norm(eye.xy), wanted.xy / np.linalg.norm(wanted.xy), atol=1e-9
        )
        assert other.reason.startswith("wanted, but")
