"""Depth as `compressed_depth_image_transport` packs it: PNG or RVL, whole or inverse numbers."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.recording.rvl import unpacked_rvl
from circumspect.sensing.millimetres import metres
from circumspect.sensing.picture import opened_picture

HEADER = struct.Struct("<iff")
"""Kind of quantisation, then its two numbers; some programs leave the header out."""
PNG = b"\x89PNG"
LARGEST = 4096
"""Pixels along a side; images of more are something else."""


def compressed_depth(image: Any, scale: float | None = None) -> NDArray[np.float32]:
    """Depth of a `CompressedImage`.

    Args:
        image: In a format such as "16UC1; compressedDepth png", "32FC1; compressedDepth rvl", or a
            plain "png" of 16 bits.
        scale: Metres a unit of whole numbers; None for millimetres.

    Returns:
        (height, width) float32 [m], NaN where invalid.

    Raises:
        InputError: Another format, or data that are broken.
    """
    words = image.format.replace(";", " ").split()
    data = bytes(image.data)
    is_inverse = "32FC1" in words
    known = "compressedDepth" in words or words == ["png"] or "png" in words[1:]
    if not known or not (is_inverse or "16UC1" in words or "mono16" in words or words == ["png"]):
        raise InputError(
            f"depth in the format {image.format[:40]!r}; known are 16UC1 and 32FC1 as "
            "compressedDepth png or rvl, and png of 16 bits"
        )
    has_header = _has_header(data, "rvl" in words)
    pixels = _pixels(data[HEADER.size :] if has_header else data, "rvl" in words)
    if not is_inverse:
        return metres(pixels) if scale is None else scaled(pixels, scale)
    if not has_header:
        raise InputError("32FC1 as compressedDepth without the header that says its quantisation")
    return _from_inverse(pixels, *HEADER.unpack_from(data)[1:]) * np.float32(scale or 1.0)


def scaled(units: NDArray[Any], scale: float) -> NDArray[np.float32]:
    """Depth in metres of whole units; 0 and 65535 are invalid.

    Args:
        units: (height, width).
        scale: Metres a unit.
    """
    depth = units.astype(np.float32) * np.float32(scale)
    depth[(units == 0) | (units == 65535)] = np.nan
    return depth


def _has_header(data: bytes, is_rvl: bool) -> bool:
    """Whether the quantisation comes first; the image's own head says where that is missing."""
    if data.startswith(PNG) or len(data) <= HEADER.size:
        return False
    # An RVL image without the header begins with its width.
    return not is_rvl or HEADER.unpack_from(data)[0] in (0, 1)


def _pixels(data: bytes, is_rvl: bool) -> NDArray[np.uint16]:
    if is_rvl and not data.startswith(PNG):
        return unpacked_rvl(data, LARGEST)
    with opened_picture(data, ("PNG",), LARGEST, "a compressed depth image") as png:
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
