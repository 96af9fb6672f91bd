"""The compression of binary_compressed PCD files."""

from __future__ import annotations

import pytest
import shape_files

from circumspect.errors import InputError
from circumspect.geometry.formats.pcd_file import decompress_lzf


@pytest.mark.parametrize(
    ("packed", "size", "word"),
    [
        (b"\x00a", 2, "1 bytes instead of 2"),
        (b"\x05ab", 6, "2 bytes instead of 6"),
        (b"\x20\x00", 3, "before their beginning"),
        (b"\x00a\xe0", 9, "too early"),
        (b"\x00a", 10**9, "can not hold"),
    ],
)
def test_broken_lzf(packed: bytes, size: int, word: str):
    with pytest.raises(InputError, match=word):
        decompress_lzf(packed, size)


@pytest.mark.parametrize("data", [b"", b"a", b"abc" * 5000, bytes(range(256)) * 50, bytes(100_000)])
def test_lzf_round_trip(data: bytes):
    assert decompress_lzf(shape_files.lzf_compressed(data), len(data)) == data
