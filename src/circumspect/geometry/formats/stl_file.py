"""STL: triangles without shared vertices, ASCII and binary."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.number_table import read_table

_HEADER_SIZE = 80
_LOOKED_AT = 1024
_TRIANGLE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
# What follows in the line is a name, which may hold any word; some files are one line.
_END = re.compile(rb"end\s*solid")
_SOLID = re.compile(rb"solid\b(?:(?!facet\s+normal\b)[^\r\n])*")
_VERTEX = re.compile(rb"\bvertex\s+(\S+[ \t]+\S+[ \t]+\S+)")


def read_stl(path: Path) -> FileShape:
    """Read triangles; stored normals and attributes are ignored.

    Raises:
        InputError: Not an STL file, or truncated.
    """
    data = path.read_bytes()
    # Binary files may also begin with "solid", and may have bytes after their triangles.
    begins_as_text = data[:_LOOKED_AT].lstrip()[:5].lower() == b"solid"
    if begins_as_text and not _size_fits(data) and b"\0" not in data[:_LOOKED_AT]:
        corners = _read_ascii(data)
    else:
        corners = _read_binary(data)
    return FileShape(corners, np.arange(len(corners), dtype=np.int64).reshape(-1, 3))


def _size_fits(data: bytes) -> bool:
    return len(data) >= _HEADER_SIZE + 4 and len(data) == _size(_count(data))


def _count(data: bytes) -> int:
    return int.from_bytes(data[_HEADER_SIZE : _HEADER_SIZE + 4], "little")


def _size(count: int) -> int:
    return _HEADER_SIZE + 4 + count * _TRIANGLE.itemsize


def _read_binary(data: bytes) -> NDArray[np.float64]:
    if len(data) < _HEADER_SIZE + 4:
        raise InputError("is not an STL file: neither a binary header nor the word solid")
    count = _count(data)
    if len(data) < _size(count):
        raise InputError(
            f"ends too early or is no STL file: {count} triangles announced in "
            f"{_size(count)} bytes, {len(data)} bytes found"
        )
    table = np.frombuffer(data, _TRIANGLE, count, _HEADER_SIZE + 4)
    return table["corners"].reshape(-1, 3).astype(np.float64)


def _read_ascii(data: bytes) -> NDArray[np.float64]:
    nameless = _SOLID.sub(b"solid", data.lower())
    lines = _VERTEX.findall(nameless)
    if len(lines) % 3 or len(lines) != nameless.count(b"vertex"):
        raise InputError("is a broken STL file: a facet without three vertices")
    if _END.search(nameless) is None:
        raise InputError("ends too early: an STL file that has no endsolid")
    return read_table(lines, rows=len(lines), columns=3)
