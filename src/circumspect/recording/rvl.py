"""Run length and variable length coding of depth (Wilson, "Fast Lossless Depth Image
Compression", ISS 2017), as `compressed_depth_image_transport` writes it.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError

SIZE = struct.Struct("<ii")
"""Columns and rows, before the code."""
LONGEST_RUN = 9
"""Groups of three bits of the length of a run."""


def unpacked_rvl(data: bytes, largest: int) -> NDArray[np.uint16]:
    """Decode an image.

    Args:
        data: Size and code.
        largest: Most pixels along a side.

    Returns:
        (height, width) uint16.

    Raises:
        InputError: The size makes no sense, or the code ends early or holds too much.
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
            raise InputError("an RVL image does not hold what it says")
        code = numbers[at : at + count]
        steps = (code >> 1) ^ -(code & 1)
        pixels[done : done + count] = before + np.cumsum(steps)
        at, done = at + count, done + count
        before = int(pixels[done - 1]) if count else before
    return (pixels & 0xFFFF).astype(np.uint16).reshape(height, width)


def _numbers(code: NDArray[np.uint8]) -> NDArray[np.int64]:
    """The numbers of the code, in groups of three bits, the lowest first.

    A nibble holds a group and, in its highest bit, whether another one follows. Eight nibbles make
    a word of 32 bits, the first one in its highest bits; words are written lowest byte first.
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
    shifted = groups << (3 * np.minimum(place, LONGEST_RUN))
    return np.add.reduceat(np.where(place < LONGEST_RUN, shifted, 0), starts)
