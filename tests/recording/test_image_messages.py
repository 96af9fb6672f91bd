"""Depth and colour in messages of ROS."""

from __future__ import annotations

import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording.image_messages import (
    BYTES,
    camera_info,
    camera_of,
    colour_message,
    colour_of,
    depth_message,
    depth_of,
    is_distorted,
)
from circumspect.sensing.millimetres import metres

SIZES = hnp.array_shapes(min_dims=2, max_dims=2, max_side=7)
WHOLE = hnp.arrays(np.uint16, SIZES)
FINE = hnp.arrays(np.float32, SIZES, elements=st.floats(0.5, 60, width=32) | st.just(np.nan))


@given(WHOLE)
def test_whole_millimetres_are_kept_in_16_bits(millimetres: np.ndarray) -> None:
    depth = metres(millimetres)
    msg = depth_message(depth, 1.5, "camera")
    assert msg.encoding == "16UC1"
    np.testing.assert_array_equal(depth_of(msg), depth)


@given(FINE)
def test_no_depth_is_lost(depth: np.ndarray) -> None:
    msg = depth_message(depth, 1.5, "camera")
    np.testing.assert_array_equal(depth_of(msg), depth)
    assert (msg.header.stamp.sec, msg.header.stamp.nanosec) == (1, 500_000_000)


def image(pixels: np.ndarray, encoding: str, pad: int = 0, big: bool = False) -> SimpleNamespace:
    """As a driver may send it: rows with padding, in either byte order."""
    ordered = pixels.astype(pixels.dtype.newbyteorder(">")) if big else pixels
    rows = ordered.view(np.uint8).reshape(len(pixels), -1)
    padded = np.pad(rows, ((0, 0), (0, pad)), constant_values=7)
    return SimpleNamespace(
        height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, is_bigendian=int(big),
        step=padded.shape[1], data=padded.ravel(),
    )  # fmt: skip


@given(WHOLE, st.integers(0, 9), st.booleans())
def test_rows_may_be_padded_and_bytes_in_either_order(
    millimetres: np.ndarray, pad: int, big: bool
) -> None:
    msg = image(np.ascontiguousarray(millimetres), "16UC1", pad, big)
    np.testing.assert_array_equal(depth_of(msg), metres(millimetres))
    fine = np.ascontiguousarray(millimetres.astype(np.float32) / 3)
    np.testing.assert_array_equal(depth_of(image(fine, "32FC1", pad, big)), fine)


@pytest.mark.parametrize("encoding", sorted(BYTES))
def test_colours_of_every_encoding(encoding: str) -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (3, 5, BYTES[encoding])).astype(np.uint8)
    colour = colour_of(image(pixels, encoding, pad=2))
    first = {"rgb": 0, "bgr": 2, "mon": 0}[encoding[:3]]
    np.testing.assert_array_equal(colour[..., 0], pixels[..., first])
    assert colour.shape == (3, 5, 3)


def test_our_colours_round_trip() -> None:
    colour = np.random.default_rng(0).integers(0, 256, (4, 6, 3)).astype(np.uint8)
    np.testing.assert_array_equal(colour_of(colour_message(colour, 0.0, "camera")), colour)


def compressed(millimetres: np.ndarray, kind: str) -> SimpleNamespace:
    held = io.BytesIO()
    Image.fromarray(millimetres).save(held, "PNG")
    data = np.frombuffer(bytes(12) + held.getvalue(), np.uint8)
    return SimpleNamespace(format=kind, data=data)


def test_compressed_depth() -> None:
    millimetres = np.random.default_rng(0).integers(0, 9000, (5, 4)).astype(np.uint16)
    msg = compressed(millimetres, "16UC1; compressedDepth png")
    np.testing.assert_array_equal(depth_of(msg), metres(millimetres))
    with pytest.raises(InputError, match=r"format '8UC1; compressedDepth'; known: 16UC1 and"):
        depth_of(compressed(millimetres, "8UC1; compressedDepth"))
    msg.data = msg.data[:40]
    with pytest.raises(InputError, match="can not be read"):
        depth_of(msg)


@given(st.floats(1e-5, 0.1))
def test_a_depth_scale_is_metres_a_unit(scale: float) -> None:
    units = np.array([[0, 1, 4000, 65534, 65535]], np.uint16)
    expected = [[np.nan, scale, 4000 * scale, 65534 * scale, np.nan]]
    held = (image(units, "16UC1"), compressed(units, "16UC1; compressedDepth png"))
    for msg in held:
        np.testing.assert_allclose(depth_of(msg, scale), expected, rtol=1e-6)
    fine = image(units.astype(np.float32), "32FC1")
    np.testing.assert_allclose(depth_of(fine, scale)[0, 2], 4000 * scale, rtol=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        {"encoding": "bayer_rggb16"},
        {"data": np.zeros(5, np.uint8)},
        {"step": 3},
        {"height": 0},
        {"width": 2**31},
        {"height": 2**31, "step": 0},
    ],
)
def test_invalid_images_are_refused(change: dict) -> None:
    msg = image(np.ones((3, 4), np.uint16), "16UC1")
    vars(msg).update(change)
    with pytest.raises(InputError):
        depth_of(msg)


def test_a_camera_round_trips() -> None:
    camera = PinholeCamera(640, 480, 570.3, 571.1, 319.25, 238.75)
    info = camera_info(camera, 2.0, "camera")
    assert camera_of(info) == camera
    assert not is_distorted(info)
    assert is_distorted(replace(info, d=np.array([0.1, 0, 0, 0, 0])))
    with pytest.raises(InputError, match="binned"):
        camera_of(replace(info, binning_x=2))


def test_rectified_images_are_those_of_the_projection_matrix() -> None:
    raw = PinholeCamera(640, 480, 585.0, 586.0, 317.0, 242.0)
    info = camera_info(raw, 2.0, "camera", (0.05, -0.1, 0.0, 0.0, 0.0))
    P = np.array([[546.0, 0, 312.5, -41.0], [0, 547.0, 239.5, 0], [0, 0, 1, 0]])
    msg = replace(info, p=P.ravel())
    assert camera_of(msg) == PinholeCamera(640, 480, 546.0, 547.0, 312.5, 239.5)
    assert camera_of(replace(msg, k=np.zeros(9))) == camera_of(msg)
    for empty in (np.zeros(12), np.zeros(0), np.full(12, np.nan)):
        assert camera_of(replace(info, p=empty)) == raw, "a driver that states K alone"


@pytest.mark.parametrize("nothing", [0.0, np.nan, np.inf, -500.0])
def test_an_uncalibrated_camera_is_refused(nothing: float) -> None:
    info = camera_info(PinholeCamera(640, 480, 570.3, 571.1, 319.25, 238.75), 2.0, "camera")
    reason = "is all zero: the driver has no calibration" if nothing == 0 else "no focal length"
    with pytest.raises(InputError, match=reason):
        camera_of(replace(info, k=np.full(9, nothing), p=np.full(12, nothing)))
