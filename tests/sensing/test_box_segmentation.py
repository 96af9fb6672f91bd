from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import BoxSegmentation, DepthNoise, RgbdFrame, continuous_pixels

CAMERA = PinholeCamera(64, 48, 60.0, 62.0, 31.5, 23.5)


@settings(deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_equals_a_test_of_every_point(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose = RigidTransform.from_components(rng.uniform(-2, 2, 3), Rotation.random(rng=rng))
    depth = (2 + 0.3 * CAMERA.rays_xyz[..., 0] + 0.5 * (rng.random() > 0.5)).astype(np.float32)
    frame = RgbdFrame(depth, CAMERA, 0.0, pose)
    middle = frame.points_map().mean(axis=0)
    corners = middle + rng.uniform(-1, 1, (2, 3))
    mask = BoxSegmentation(*corners).object_mask(frame)
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = frame.points_map()
    inside = ((points >= low) & (points <= high)).all(axis=1).reshape(48, 64)
    near_a_face = (np.minimum(abs(points - low), abs(points - high)) < 1e-5).any(axis=1)
    expected = inside & continuous_pixels(depth, CAMERA, DepthNoise())
    assert (mask == expected)[~near_a_face.reshape(48, 64)].all()


def test_corners_may_come_in_any_order() -> None:
    a, b = BoxSegmentation([0, 1, 2], [3, -1, 5]), BoxSegmentation([3, -1, 2], [0, 1, 5])
    np.testing.assert_array_equal(a.low_xyz, b.low_xyz)
    np.testing.assert_array_equal(a.high_xyz, b.high_xyz)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ([0, 0], [1, 1]),
        ([0, 0], [1, 1, 1]),
        ([0, 0, 0], [[1, 1, 1]]),
        ([0, 0, 0], None),
        ([0, 0, "a"], [1, 1, 1]),
        ([0, 0, 10**400], [1, 1, 1]),
        ([0, 0, 0], [1, 1, np.nan]),
        ([0, 0, 0], [1, 0, 1]),
        ([0, 0, 0], [1, np.inf, 1]),
    ],
)
def test_bad_corners(a: list[float], b: list[float]) -> None:
    with pytest.raises(InputError, match="box") as error:
        BoxSegmentation(a, b)
    assert str(error.value).isprintable()


def test_a_frame_without_a_pose_is_refused() -> None:
    with pytest.raises(InputError, match="no pose"):
        BoxSegmentation([0, 0, 0], [1, 1, 1]).object_mask(RgbdFrame(np.ones((48, 64)), CAMERA, 0.0))


def test_an_empty_frame_has_no_object() -> None:
    frame = RgbdFrame(np.full((48, 64), np.nan), CAMERA, 0.0, RigidTransform.identity())
    assert not BoxSegmentation([0, 0, 0], [1, 1, 1]).object_mask(frame).any()
