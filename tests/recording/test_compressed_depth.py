"""Depth as compressed_depth_image_transport packs it, made by an encoder of its own here."""

from __future__ import annotations

import io
import struct
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from circumspect.errors import InputError
from circumspect.recording.compressed_depth import compressed_depth, decoded_rvl
from circumspect.sensing.millimetres import metres

PIXELS = hnp.arrays(
    np.uint16,
    hnp.array_shapes(min_dims=2, max_dims=2, max_side=9),
    elements=st.just(0) | st.integers(0, 65535),
)


def rvl(pixels: np.ndarray) -> bytes:
    """The transport's encoder, one number after the other."""
    nibbles: list[int] = []

    def number(value: int) -> None:
        while True:
            value, low = value >> 3, value & 7
            nibbles.append(low | (8 if value else 0))
            if not value:
                return

    flat, at, before = pixels.ravel().astype(int).tolist(), 0, 0
    while at < len(flat):
        zeros = next((k for k, v in enumerate(flat[at:]) if v), len(flat) - at)
        at += zeros
        count = next((k for k, v in enumerate(flat[at:]) if not v), len(flat) - at)
        number(zeros)
        number(count)
        for value in flat[at : at + count]:
            step, before = value - before, value
            number(2 * step if step >= 0 else -2 * step - 1)
        at += count
    nibbles += [0] * (-len(nibbles) % 8)
    words = [
        int("".join(f"{n:x}" for n in nibbles[k : k + 8]), 16) for k in range(0, len(nibbles), 8)
    ]
    height, width = pixels.shape
    return struct.pack("<ii", width, height) + struct.pack(f"<{len(words)}I", *words)


def png(pixels: np.ndarray) -> bytes:
    held = io.BytesIO()
    Image.fromarray(pixels).save(held, "PNG")
    return held.getvalue()


def packed(kind: str, data: bytes, a: float = 0.0, b: float = 0.0, header: bool = True):
    head = struct.pack("<iff", 1 if a else 0, a, b) if header else b""
    return SimpleNamespace(format=kind, data=np.frombuffer(head + data, np.uint8))


@given(PIXELS)
def test_rvl_round_trip(pixels: np.ndarray) -> None:
    np.testing.assert_array_equal(decoded_rvl(rvl(pixels), 9), pixels)


@given(PIXELS)
def test_whole_millimetres_round_trip_with_and_without_a_header(pixels: np.ndarray) -> None:
    for kind, data in (("png", png(pixels)), ("rvl", rvl(pixels))):
        for header in (True, False):
            if kind == "rvl" and not header and pixels.shape[1] < 2:
                continue
            msg = packed(f"16UC1; compressedDepth {kind}", data, header=header)
            np.testing.assert_array_equal(compressed_depth(msg), metres(pixels))


@pytest.mark.parametrize("kind", ["16UC1; png compressed ", "png", "mono16; png compressed"])
def test_a_plain_png_of_16_bits_is_depth(kind: str) -> None:
    pixels = np.array([[0, 700, 1500]], np.uint16)
    msg = packed(kind, png(pixels), header=False)
    np.testing.assert_array_equal(compressed_depth(msg), metres(pixels))


@given(st.floats(0.3, 9.0), st.floats(10, 120))
def test_metres_are_kept_as_the_transport_quantises_them(depth: float, quantisation: float) -> None:
    a = quantisation * (quantisation + 1)
    b = 1 - a / 10.0
    pixels = np.array([[0, int(a / depth + b)]], np.uint16)
    for data, kind in ((png(pixels), "png"), (rvl(pixels), "rvl")):
        found = compressed_depth(packed(f"32FC1; compressedDepth {kind}", data, a, b))
        assert np.isnan(found[0, 0])
        # A step of the inverse depth.
        assert found[0, 1] == pytest.approx(depth, abs=1.01 * depth**2 / (a - depth))


def test_inverse_depth_needs_its_quantisation() -> None:
    pixels = np.ones((2, 2), np.uint16)
    with pytest.raises(InputError, match="lacks the header"):
        compressed_depth(packed("32FC1; compressedDepth png", png(pixels), header=False))
    with pytest.raises(InputError, match="the quantisation 0, 0"):
        compressed_depth(packed("32FC1; compressedDepth png", png(pixels)))


@given(st.binary(max_size=60))
def test_broken_rvl_is_refused_or_an_image(data: bytes) -> None:
    try:
        pixels = decoded_rvl(data, 64)
    except InputError:
        return
    assert pixels.dtype == np.uint16


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"\0" * 5, "before its size"),
        (struct.pack("<ii", 2**30, 4), "1073741824 x 4"),
        (struct.pack("<ii", 4, 4), "ends early"),
        (struct.pack("<iiI", 4, 4, 0), "does not match its size"),
        (struct.pack("<iiI", 4, 4, 0xFFFFFFF7), "ends early"),
    ],
)
def test_invalid_rvl_is_refused(data: bytes, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        decoded_rvl(data, 4096)
