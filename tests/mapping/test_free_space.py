"""What frames showed to be empty."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import PinholeCamera
from circumspect.mapping.free_space import SLACK, SLACK_GROWTH, FreeSpace
from circumspect.sensing import RgbdFrame

CAMERA = PinholeCamera(80, 64, 70.0, 70.0, 39.5, 31.5)


def space(depth: np.ndarray) -> FreeSpace:
    return FreeSpace.of(RgbdFrame(depth, CAMERA, 0.0))


def ahead(z: float, u: float = 39.5, v: float = 31.5) -> np.ndarray:
    return np.array([[(u - CAMERA.cx) / CAMERA.fx * z, (v - CAMERA.cy) / CAMERA.fy * z, z]])


WALL = np.full((64, 80), 2.0)


@given(st.floats(0.1, 4.0), st.floats(4, 75), st.floats(4, 59))
def test_before_a_wall_it_is_empty_and_behind_it_unknown(z: float, u: float, v: float) -> None:
    held = bool(space(WALL).holds(ahead(z, u, v))[0])
    if z + SLACK + SLACK_GROWTH * z**2 < 2.0 - 1e-6:
        assert held
    if z > 2.0 - SLACK:
        assert not held


@given(st.floats(-5.0, 0.0), st.floats(-1, 1), st.floats(-1, 1))
def test_nothing_behind_the_camera_is_known(z: float, x: float, y: float) -> None:
    point = np.array([[x, y, z]])
    assert not space(WALL).holds(point)[0]
    assert not space(WALL).shows(point, 0.15)[0]


def test_out_of_view_and_without_depth_nothing_is_known() -> None:
    assert not space(WALL).holds(ahead(1.0, u=200.0))[0]
    hole = WALL.copy()
    hole[24:40, 32:48] = np.nan
    assert not space(hole).holds(ahead(1.0))[0]
    assert not space(np.full((64, 80), np.nan)).holds(ahead(1.0))[0]


def test_beside_something_near_it_is_not_taken_for_empty() -> None:
    post = WALL.copy()
    post[:, 40:42] = 0.8
    assert not space(post).holds(ahead(1.2, u=46.0))[0]
    assert space(post).holds(ahead(1.2, u=70.0))[0]


def test_it_shows_what_lies_on_the_wall() -> None:
    on, before = ahead(1.95), ahead(1.5)
    assert space(WALL).shows(on, 0.15)[0]
    assert not space(WALL).shows(before, 0.15)[0]
