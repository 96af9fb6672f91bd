from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import RgbdFrame

CAMERA = PinholeCamera(8, 6, 10.0, 11.0, 3.5, 2.5)


def some_depth(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.5, 4.0, (6, 8)).astype(np.float32)
    depth[rng.random((6, 8)) < 0.3] = np.nan
    return depth


@given(seed=st.integers(0, 2**32 - 1), masked=st.booleans())
def test_points_in_map_are_the_back_projection_moved_by_the_pose(seed: int, masked: bool) -> None:
    rng = np.random.default_rng(seed)
    pose = RigidTransform.from_components(rng.uniform(-9, 9, 3), Rotation.random(rng=rng))
    frame = RgbdFrame(some_depth(seed), CAMERA, 0.0, pose)
    mask = rng.random((6, 8)) < 0.5 if masked else None
    expected = CAMERA.back_project(frame.depth, mask)
    if len(expected):
        expected = pose.apply(expected)
    np.testing.assert_allclose(frame.points_map(mask), expected, atol=1e-5)


@pytest.mark.parametrize("bad", [np.inf, -np.inf, np.nan, 0.0, -1.0])
def test_values_that_are_no_distances_are_invalid(bad: float) -> None:
    depth = np.full((6, 8), 2.0)
    depth[3, 4] = bad
    frame = RgbdFrame(depth, CAMERA, 0.0)
    assert np.isnan(frame.depth[3, 4])
    assert frame.valid.sum() == 47


def test_millimetres_0_and_65535_are_invalid() -> None:
    raw = np.full((6, 8), 1234, np.uint16)
    raw[0, 0], raw[0, 1] = 0, 65535
    frame = RgbdFrame.from_millimetres(raw, CAMERA, 1.5)
    assert np.isnan(frame.depth[0, :2]).all()
    np.testing.assert_allclose(frame.depth[1:], 1.234, rtol=1e-6)


def test_a_frame_keeps_its_own_read_only_copy() -> None:
    depth = np.full((6, 8), 2.0, np.float32)
    frame = RgbdFrame(depth, CAMERA, 0.0)
    depth[:] = 3.0
    assert (frame.depth == 2.0).all()
    with pytest.raises(ValueError, match="read-only"):
        frame.depth[0, 0] = 1.0


def test_wrong_depth_shape_states_both_shapes() -> None:
    with pytest.raises(InputError, match=r"\(8, 6\).*\(6, 8\)"):
        RgbdFrame(np.ones((8, 6)), CAMERA, 0.0)


def test_wrong_colour_shape() -> None:
    with pytest.raises(InputError, match="colour"):
        RgbdFrame(np.ones((6, 8)), CAMERA, 0.0, colour=np.zeros((6, 8), np.uint8))


@pytest.mark.parametrize("stamp", [np.nan, np.inf])
def test_stamp_must_be_finite(stamp: float) -> None:
    with pytest.raises(InputError, match="stamp"):
        RgbdFrame(np.ones((6, 8)), CAMERA, stamp)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize(
    ("field", "name"), [("T_map_camera", "pose"), ("T_base_camera", r"mount \(T_base_camera\)")]
)
def test_pose_and_mount_must_be_finite(field: str, name: str, value: float) -> None:
    with np.errstate(invalid="ignore"):
        T = RigidTransform.from_translation([value, 0.0, 0.0])
    with pytest.raises(InputError, match=rf"the {name} of the frame at 7\.250 s is not finite"):
        RgbdFrame(np.ones((6, 8)), CAMERA, 7.25, **{field: T})


def test_a_missing_pose_is_refused() -> None:
    frame = RgbdFrame(np.ones((6, 8)), CAMERA, 7.25)
    with pytest.raises(InputError, match=r"7\.250 s has no pose"):
        frame.points_map()
    assert frame.at(RigidTransform.identity()).points_map().shape == (48, 3)


def test_depths_out_of_range_in_any_unit_are_invalid():
    depth = np.array([[1e-38, 1e-20, 1e-3], [1.0, -1.0, np.inf]], np.float32)
    frame = RgbdFrame(depth, PinholeCamera(3, 2, 1.0, 1.0, 1.0, 0.5), 0.0)
    assert frame.valid.tolist() == [[False, False, True], [True, False, False]]


@pytest.mark.parametrize("dtype", [np.float32, np.uint16])
def test_masked_depth_is_invalid(dtype):
    depth = np.ma.masked_array(np.full((6, 8), 2, dtype), mask=np.zeros((6, 8), bool))
    depth[1, 2] = np.ma.masked
    for frame in (
        RgbdFrame(depth, CAMERA, 0.0),
        RgbdFrame.from_millimetres(depth, CAMERA, 0.0),
    ):
        assert np.isnan(frame.depth[1, 2])
        assert frame.valid.sum() == 47
