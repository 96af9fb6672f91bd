"""LZF decompression, as PCD files use it."""

from __future__ import annotations

from circumspect.errors import InputError

_LONGEST_RUN = 264  # bytes that at most three packed bytes stand for


def decompress_lzf(packed: bytes, size: int) -> bytes:
    """Unpack `packed` to `size` bytes.

    Raises:
        InputError: The data are broken or do not unpack to that size.
    """
    if size > _LONGEST_RUN * len(packed):
        raise InputError(f"is broken: {len(packed)} packed bytes can not hold {size}")
    unpacked = bytearray()
    position, end = 0, len(packed)
    try:
        while position < end and len(unpacked) <= size:
            control = packed[position]
            position += 1
            if control < 32:  # The next control + 1 bytes stand as they are.
                unpacked += packed[position : position + control + 1]
                position += control + 1
                continue
            length = (control >> 5) + 2
            if length == 9:
                length += packed[position]
                position += 1
            start = len(unpacked) - ((control & 31) << 8) - packed[position] - 1
            position += 1
            if start < 0:
                raise InputError("is broken: its packed data refer to before their beginning")
            piece = unpacked[start : start + length]
            while len(piece) < length:  # The run overlaps itself: it repeats.
                piece += piece[: length - len(piece)]
            unpacked += piece
    except IndexError:
        raise InputError("is broken: its packed data end too early") from None
    if len(unpacked) != size:
        raise InputError(f"is broken: unpacks to {len(unpacked)} bytes instead of {size}")
    return bytes(unpacked)
