"""Decoder of `compressed_depth_image_transport`: PNG or RVL, depth or inverse depth."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.sensing.millimetres import metres
from circumspect.sensing.untrusted_files import opened_picture

HEADER = struct.Struct("<iff")
"""Kind of quantisation and its two parameters; some programs omit this header."""
PNG = b"\x89PNG"
MAX_SIDE_PX = 4096
"""Maximum image side [px]."""
SIZE = struct.Struct("<ii")
"""Width and height, before the code."""
MAX_RUN_GROUPS = 9
"""Maximum number of 3-bit groups in a run length."""


def compressed_depth(image: Any, scale: float | None = None) -> NDArray[np.float32]:
    """Depth of a `CompressedImage`.

    Args:
        image: Format such as "16UC1; compressedDepth png", "32FC1; compressedDepth rvl", or a plain
            16-bit "png".
        scale: Metres per unit of integer depth; None for millimetres.

    Returns:
        (height, width) float32 [m], NaN where invalid.

    Raises:
        InputError: Unknown format or broken data.
    """
    words = image.format.replace(";", " ").split()
    data = bytes(image.data)
    is_inverse = "32FC1" in words
    known = "compressedDepth" in words or words == ["png"] or "png" in words[1:]
    if not known or not (is_inverse or "16UC1" in words or "mono16" in words or words == ["png"]):
        raise InputError(
            f"unknown depth format {image.format[:40]!r}; known: 16UC1 and 32FC1 as "
            "compressedDepth png or rvl, and 16-bit png"
        )
    has_header = _has_header(data, "rvl" in words)
    pixels = _pixels(data[HEADER.size :] if has_header else data, "rvl" in words)
    if not is_inverse:
        return metres(pixels) if scale is None else scaled(pixels, scale)
    if not has_header:
        raise InputError("32FC1 as compressedDepth lacks the header with its quantisation")
    return _from_inverse(pixels, *HEADER.unpack_from(data)[1:]) * np.float32(scale or 1.0)


def scaled(units: NDArray[Any], scale: float) -> NDArray[np.float32]:
    """Convert integer depth to metres; 0 and 65535 are invalid.

    Args:
        units: (height, width).
        scale: Metres per unit.
    """
    depth = units.astype(np.float32) * np.float32(scale)
    depth[(units == 0) | (units == 65535)] = np.nan
    return depth


def _has_header(data: bytes, is_rvl: bool) -> bool:
    """Whether the data start with the quantisation header, judged by the image's own header."""
    if data.startswith(PNG) or len(data) <= HEADER.size:
        return False
    # Without the header, an RVL image begins with its width.
    return not is_rvl or HEADER.unpack_from(data)[0] in (0, 1)


def _pixels(data: bytes, is_rvl: bool) -> NDArray[np.uint16]:
    if is_rvl and not data.startswith(PNG):
        return decoded_rvl(data, MAX_SIDE_PX)
    with opened_picture(data, ("PNG",), MAX_SIDE_PX, "a compressed depth image") as png:
        if png.mode not in ("I;16", "I;16B", "I"):
            raise InputError(f"a depth image in mode {png.mode}")
        return np.asarray(png).astype(np.uint16)


def _from_inverse(pixels: NDArray[np.uint16], a: float, b: float) -> NDArray[np.float32]:
    """Z = a / (d - b), as the transport quantises 32FC1."""
    if not (np.isfinite(a) and np.isfinite(b) and a > 0):
        raise InputError(f"32FC1 as compressedDepth with the quantisation {a:g}, {b:g}")
    difference = pixels.astype(np.float32) - np.float32(b)
    valid = (pixels > 0) & (difference > 0)
    depth = np.full(pixels.shape, np.nan, np.float32)
    depth[valid] = np.float32(a) / difference[valid]
    return depth


def decoded_rvl(data: bytes, largest: int) -> NDArray[np.uint16]:
    """Decode an RVL image.

    Args:
        data: Size and code.
        largest: Maximum image side [px].

    Returns:
        (height, width) uint16.

    Raises:
        InputError: The size is impossible, or the code is too short or too long.
    """
    if len(data) < SIZE.size:
        raise InputError("an RVL image ends before its size")
    width, height = SIZE.unpack_from(data)
    if not (0 < width <= largest and 0 < height <= largest):
        raise InputError(f"an RVL image of {width} x {height} pixels")
    numbers = _numbers(np.frombuffer(data, np.uint8, offset=SIZE.size))
    pixels = np.zeros(width * height, np.int64)
    done = at = before = 0
    while done < len(pixels):
        if at + 2 > len(numbers):
            raise InputError("an RVL image ends early")
        zeros, count = int(numbers[at]), int(numbers[at + 1])
        at, done = at + 2, done + zeros
        if done + count > len(pixels) or at + count > len(numbers) or zeros + count == 0:
            raise InputError("an RVL image does not match its size")
        code = numbers[at : at + count]
        steps = (code >> 1) ^ -(code & 1)
        pixels[done : done + count] = before + np.cumsum(steps)
        at, done = at + count, done + count
        before = int(pixels[done - 1]) if count else before
    return (pixels & 0xFFFF).astype(np.uint16).reshape(height, width)


def _numbers(code: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Decode the variable-length numbers, made of 3-bit groups with the lowest first.

    A nibble holds a group; its highest bit says whether another group follows. Eight nibbles make a
    32-bit little-endian word, with the first nibble in the highest bits.
    """
    words = np.frombuffer(np.pad(code, (0, -len(code) % 4)).tobytes(), "<u4")
    nibbles = ((words[:, None] >> np.arange(28, -1, -4, dtype=np.uint32)) & 15).ravel()
    nibbles = nibbles.astype(np.int64)
    ends = np.flatnonzero(nibbles < 8)
    if not len(ends):
        return np.empty(0, np.int64)
    starts = np.concatenate([[0], ends[:-1] + 1])
    place = np.arange(ends[-1] + 1) - np.repeat(starts, ends - starts + 1)
    groups = nibbles[: ends[-1] + 1] & 7
    shifted = groups << (3 * np.minimum(place, MAX_RUN_GROUPS))
    return np.add.reduceat(np.where(place < MAX_RUN_GROUPS, shifted, 0), starts)
