"""Decompression of recordings with a limit on the size of the output.

A few bytes can decompress to any size, and the libraries that read bags have no limits. Their
decompressors are replaced by the ones in this module.
"""

from __future__ import annotations

import bz2
import os
from functools import cache
from typing import IO, Any, TypeAlias

from circumspect.errors import InputError

_Bytes: TypeAlias = bytes | bytearray | memoryview

MAX_UNPACKED_BYTES = 2**28
"""Maximum size of a decompressed chunk or message [bytes]."""
MAX_WINDOW_BYTES = 2**27
"""Maximum window of Zstandard [bytes]."""
ALWAYS_ALLOWED_BYTES = 2**30
MAX_EXPANSION = 64
"""Limit of a compressed file's expansion; `ALWAYS_ALLOWED_BYTES` are allowed in any case."""


def decompressed(data: _Bytes, compression: str, size: int = MAX_UNPACKED_BYTES) -> _Bytes:
    """Decompress data.

    Args:
        data: Compressed data.
        compression: "zstd", "lz4", "bz2", or "" for none.
        size: Maximum size of the result [bytes].

    Raises:
        InputError: The result is larger, the data end early, or the compression is unknown. Broken
            data may raise other exceptions as well.
    """
    if compression == "":
        return data
    if compression not in _DECOMPRESSORS:
        raise InputError(
            f"unknown compression {compression[:20]!r}; known: {', '.join(_DECOMPRESSORS)}"
        )
    if size > MAX_UNPACKED_BYTES:
        raise InputError(f"a part of {size} bytes exceeds the limit of {MAX_UNPACKED_BYTES}")
    return _DECOMPRESSORS[compression](data, size)


def _decompressed_zstd(data: _Bytes, size: int) -> bytearray:
    import zstandard

    decompressor = zstandard.ZstdDecompressor(max_window_size=MAX_WINDOW_BYTES)
    with decompressor.stream_reader(data, read_across_frames=True) as stream:
        return _read_bounded(stream, size)


def _decompressed_lz4(data: _Bytes, size: int) -> bytes:
    import lz4.frame

    decompressor = lz4.frame.LZ4FrameDecompressor()
    return _checked(
        decompressor.decompress(data, max_length=size + 1), bool(decompressor.eof), size
    )


def _decompressed_bz2(data: _Bytes, size: int) -> bytes:
    decompressor = bz2.BZ2Decompressor()
    return _checked(decompressor.decompress(data, max_length=size + 1), decompressor.eof, size)


_DECOMPRESSORS = {"zstd": _decompressed_zstd, "lz4": _decompressed_lz4, "bz2": _decompressed_bz2}


def _read_bounded(stream: Any, size: int) -> bytearray:
    found = bytearray()
    while part := stream.read(min(1 << 20, size + 1 - len(found))):
        found += part
        if len(found) > size:
            raise InputError(f"decompresses to more than {size} bytes")
    return found


def _checked(found: bytes, ended: bool, size: int) -> bytes:
    if len(found) > size:
        raise InputError(f"decompresses to more than {size} bytes")
    if not ended:
        raise InputError("compressed data end too early")
    return found


@cache
def bound_rosbags() -> None:
    """Replace the decompressors of rosbags in this process by bounded ones."""
    import rosbags.rosbag1.reader as first
    import rosbags.rosbag2.reader as second
    import rosbags.rosbag2.storage_mcap as mcap

    first.decompressors.update(
        {
            name: lambda data, name=name: bytes(decompressed(data, name))
            for name in first.decompressors
            if name in _DECOMPRESSORS
        }
    )
    mcap.DECOMPRESSORS.update(
        {
            name: lambda data, size, name=name: bytes(decompressed(data, name, size))
            for name in mcap.DECOMPRESSORS
            if name
        }
    )
    setattr(second, "zstd", _BoundedZstd())  # noqa: B010 - no public name, but the one it uses


class _BoundedZstd:
    """Replaces the module `zstd` in rosbags."""

    @staticmethod
    def decompress(data: bytes) -> bytes:
        return bytes(decompressed(data, "zstd"))

    @staticmethod
    def open(stream: IO[bytes], mode: str) -> _BoundedStream:
        if mode != "rb":
            raise ValueError(f"opened for {mode!r}")
        return _BoundedStream(stream)


class _BoundedStream:
    """The decompressed content of a file."""

    def __init__(self, stream: IO[bytes]) -> None:
        import zstandard

        size = os.fstat(stream.fileno()).st_size
        self._left = max(ALWAYS_ALLOWED_BYTES, MAX_EXPANSION * size)
        decompressor = zstandard.ZstdDecompressor(max_window_size=MAX_WINDOW_BYTES)
        self._stream = decompressor.stream_reader(stream, read_across_frames=True, closefd=False)

    def read(self, size: int = 1 << 20) -> bytes:
        part = self._stream.read(size)
        self._left -= len(part)
        if self._left < 0:
            raise InputError("a compressed file of the bag is too large when decompressed")
        return part

    def __enter__(self) -> _BoundedStream:
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()
