"""Packed parts of recordings, unpacked to a size that was agreed on and not a byte more.

A few bytes can unpack to anything. The libraries that read bags unpack without limits, so what
unpacks for them is replaced.
"""

from __future__ import annotations

import bz2
import os
from functools import cache
from typing import IO, Any, TypeAlias

from circumspect.errors import InputError

_Bytes: TypeAlias = bytes | bytearray | memoryview

LARGEST = 2**28
"""Chunks and messages of more bytes are refused."""
WIDEST_WINDOW = 2**27
"""Zstandard keeps so many bytes at hand."""
HARMLESS_FILE = 2**30
MOST_UNPACKED = 64
"""A packed file of a bag may unpack to so many times its size, or to what does no harm."""


def unpacked(data: _Bytes, packing: str, size: int = LARGEST) -> _Bytes:
    """Unpack.

    Args:
        data: What is packed.
        packing: "zstd", "lz4", "bz2", or "" for none.
        size: What it unpacks to at most [bytes].

    Raises:
        InputError: It unpacks to more, ends early, or the packing is unknown. Broken data may
            raise other exceptions as well.
    """
    if packing == "":
        return data
    if packing not in _UNPACKERS:
        raise InputError(f"packed as {packing[:20]!r}; known are {', '.join(_UNPACKERS)}")
    if size > LARGEST:
        raise InputError(f"{size} bytes in one piece; {LARGEST} are read")
    return _UNPACKERS[packing](data, size)


def _unpacked_zstd(data: _Bytes, size: int) -> bytearray:
    import zstandard

    machine = zstandard.ZstdDecompressor(max_window_size=WIDEST_WINDOW)
    with machine.stream_reader(data, read_across_frames=True) as stream:
        return _at_most(stream, size)


def _unpacked_lz4(data: _Bytes, size: int) -> bytes:
    import lz4.frame

    machine = lz4.frame.LZ4FrameDecompressor()
    return _checked(machine.decompress(data, max_length=size + 1), bool(machine.eof), size)


def _unpacked_bz2(data: _Bytes, size: int) -> bytes:
    machine = bz2.BZ2Decompressor()
    return _checked(machine.decompress(data, max_length=size + 1), machine.eof, size)


_UNPACKERS = {"zstd": _unpacked_zstd, "lz4": _unpacked_lz4, "bz2": _unpacked_bz2}


def _at_most(stream: Any, size: int) -> bytearray:
    found = bytearray()
    while part := stream.read(min(1 << 20, size + 1 - len(found))):
        found += part
        if len(found) > size:
            raise InputError(f"unpacks to more than {size} bytes")
    return found


def _checked(found: bytes, ended: bool, size: int) -> bytes:
    if len(found) > size:
        raise InputError(f"unpacks to more than {size} bytes")
    if not ended:
        raise InputError("packed data end too early")
    return found


@cache
def bound_rosbags() -> None:
    """Let rosbags unpack within limits, from now on and in all of this process."""
    import rosbags.rosbag1.reader as first
    import rosbags.rosbag2.reader as second
    import rosbags.rosbag2.storage_mcap as mcap

    first.decompressors.update(
        {
            name: lambda data, name=name: bytes(unpacked(data, name))
            for name in first.decompressors
            if name in _UNPACKERS
        }
    )
    mcap.DECOMPRESSORS.update(
        {
            name: lambda data, size, name=name: bytes(unpacked(data, name, size))
            for name in mcap.DECOMPRESSORS
            if name
        }
    )
    setattr(second, "zstd", _BoundedZstd())  # noqa: B010 - no public name, but the one it uses


class _BoundedZstd:
    """In the place of the module that rosbags knows as zstd."""

    @staticmethod
    def decompress(data: bytes) -> bytes:
        return bytes(unpacked(data, "zstd"))

    @staticmethod
    def open(stream: IO[bytes], mode: str) -> _BoundedStream:
        if mode != "rb":
            raise ValueError(f"opened for {mode!r}")
        return _BoundedStream(stream)


class _BoundedStream:
    """The plain bytes of a packed file."""

    def __init__(self, stream: IO[bytes]) -> None:
        import zstandard

        size = os.fstat(stream.fileno()).st_size
        self._left = max(HARMLESS_FILE, MOST_UNPACKED * size)
        machine = zstandard.ZstdDecompressor(max_window_size=WIDEST_WINDOW)
        self._stream = machine.stream_reader(stream, read_across_frames=True, closefd=False)

    def read(self, size: int = 1 << 20) -> bytes:
        part = self._stream.read(size)
        self._left -= len(part)
        if self._left < 0:
            raise InputError("a packed file of the bag unpacks to far more than it may")
        return part

    def __enter__(self) -> _BoundedStream:
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()
