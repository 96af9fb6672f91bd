"""The pose of a camera in the hand, from the floor that it sees."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.geometry import PinholeCamera
from circumspect.sensing import RgbdFrame
from circumspect.sensing.floor_plane import floor_pose
from circumspect.sensing.pixel_rays import pixel_rays
from circumspect.sensing.viewing import looking

CAMERA = PinholeCamera(80, 60, 70.0, 70.0, 39.5, 29.5)


def frame_of_planes(
    T_map_camera: RigidTransform, heights: tuple[float, ...] = (0.0,), noise: float = 0.0
):
    """A frame of level planes; the highest one is a box of half a metre, 1.2 m ahead."""
    rays = T_map_camera.rotation.apply(pixel_rays(CAMERA).reshape(-1, 3).astype(float))
    origin = T_map_camera.translation
    depth = np.full(len(rays), np.inf)
    for height in heights:
        with np.errstate(divide="ignore", invalid="ignore"):
            far = (height - origin[2]) / rays[:, 2]
        at = origin + far[:, None] * rays
        ahead = np.abs(at[:, :2] - origin[:2] - [1.2, 0.0]).max(axis=1) < 0.25
        hit = (far > 0) & (far < 4.0) & (ahead if height else True)
        depth = np.where(hit & (far < depth), far, depth)
    depth = np.where(np.isfinite(depth), depth, np.nan).reshape(60, 80)
    depth = depth + np.random.default_rng(1).normal(0, noise, depth.shape)
    return RgbdFrame(depth.astype(np.float32), CAMERA, 0.0)


@settings(max_examples=15)
@given(st.floats(0.5, 2.0), st.floats(25, 65), st.floats(-15, 15))
def test_height_tilt_and_roll_are_found(height: float, tilt: float, roll: float) -> None:
    upright = looking([0, 0, height], 0.0, np.radians(tilt))
    rolled = upright * RigidTransform.from_rotation(Rotation.from_euler("z", roll, degrees=True))
    found = floor_pose(frame_of_planes(rolled, (0.0, 0.45), noise=0.003))
    assert found is not None
    assert found.translation == pytest.approx([0, 0, height], abs=0.01)
    np.testing.assert_allclose(found.as_matrix(), rolled.as_matrix(), atol=0.02)


def test_a_table_over_the_floor_is_no_floor() -> None:
    found = floor_pose(frame_of_planes(looking([0, 0, 1.4], 0.0, np.radians(45)), (0.0, 0.7)))
    assert found is not None
    assert found.translation[2] == pytest.approx(1.4, abs=0.01)


def test_a_wall_or_nothing_is_no_floor() -> None:
    wall = RgbdFrame(np.full((60, 80), 2.0, np.float32), CAMERA, 0.0)
    nothing = RgbdFrame(np.full((60, 80), np.nan, np.float32), CAMERA, 0.0)
    assert floor_pose(wall) is None
    assert floor_pose(nothing) is None
