"""Free space of frames."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import PinholeCamera
from circumspect.registration import FreeSpace
from circumspect.registration.free_space import MARGIN_GROWTH_PER_M, MARGIN_M
from circumspect.sensing import RgbdFrame

CAMERA = PinholeCamera(80, 64, 70.0, 70.0, 39.5, 31.5)


def space(depth: np.ndarray) -> FreeSpace:
    return FreeSpace.from_frame(RgbdFrame(depth, CAMERA, 0.0))


def ahead(z: float, u: float = 39.5, v: float = 31.5) -> np.ndarray:
    return np.array([[(u - CAMERA.cx) / CAMERA.fx * z, (v - CAMERA.cy) / CAMERA.fy * z, z]])


WALL = np.full((64, 80), 2.0)


@given(st.floats(0.1, 4.0), st.floats(4, 75), st.floats(4, 59))
def test_space_in_front_of_a_wall_is_free_and_behind_it_is_not(
    z: float, u: float, v: float
) -> None:
    free = bool(space(WALL).contains(ahead(z, u, v))[0])
    if z + MARGIN_M + MARGIN_GROWTH_PER_M * z**2 < 2.0 - 1e-6:
        assert free
    if z > 2.0 - MARGIN_M:
        assert not free


@given(st.floats(-5.0, 0.0), st.floats(-1, 1), st.floats(-1, 1))
def test_space_behind_the_camera_is_unknown(z: float, x: float, y: float) -> None:
    point = np.array([[x, y, z]])
    assert not space(WALL).contains(point)[0]
    assert not space(WALL).agrees_with(point, 0.15)[0]


def test_space_out_of_view_or_without_depth_is_unknown() -> None:
    assert not space(WALL).contains(ahead(1.0, u=200.0))[0]
    hole = WALL.copy()
    hole[24:40, 32:48] = np.nan
    assert not space(hole).contains(ahead(1.0))[0]
    assert not space(np.full((64, 80), np.nan)).contains(ahead(1.0))[0]


def test_space_beside_a_near_object_is_not_free() -> None:
    post = WALL.copy()
    post[:, 40:42] = 0.8
    assert not space(post).contains(ahead(1.2, u=46.0))[0]
    assert space(post).contains(ahead(1.2, u=70.0))[0]


def test_points_on_the_wall_agree_with_the_depth() -> None:
    on, before = ahead(1.95), ahead(1.5)
    assert space(WALL).agrees_with(on, 0.15)[0]
    assert not space(WALL).agrees_with(before, 0.15)[0]
