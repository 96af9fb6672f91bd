"""PCD: the clouds of the Point Cloud Library, ASCII, binary and compressed."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.column_titles import unique_names
from circumspect.geometry.formats.file_shape import FileShape, side_by_side
from circumspect.geometry.formats.number_table import read_table

_TYPES = {
    ("F", 4): "<f4", ("F", 8): "<f8",
    ("I", 1): "<i1", ("I", 2): "<i2", ("I", 4): "<i4", ("I", 8): "<i8",
    ("U", 1): "<u1", ("U", 2): "<u2", ("U", 4): "<u4", ("U", 8): "<u8",
}  # fmt: skip
MAX_FIELDS = 500
UNCHECKED_BYTES = 64 << 20
MAX_UNPACKING_RATIO = 16
"""Largest ratio of unpacked to packed size of large data; measurements reach two or three."""
_MAX_RUN_BYTES = 264  # bytes that at most three packed bytes stand for


@dataclass(frozen=True)
class PcdHeader:
    """The header.

    Attributes:
        fields: (name, NumPy type, values a point) in the order of the file.
        points: Number of points.
        encoding: "ascii", "binary" or "binary_compressed".
        size: Bytes up to the first point.
    """

    fields: tuple[tuple[str, str, int], ...]
    points: int
    encoding: str
    size: int


def read_pcd(path: Path) -> FileShape:
    """Read the fields x y z and, where given, normal_x normal_y normal_z.

    The viewpoint and other fields are ignored.

    Raises:
        InputError: Not a PCD file, truncated, or broken.
    """
    data = path.read_bytes()
    header = parse_pcd_header(data)
    if header.encoding not in _DECODERS:
        known = ", ".join(_DECODERS)
        raise InputError(f"has unknown data {header.encoding!r}; known: {known}")
    columns = _DECODERS[header.encoding](data, header)
    points = side_by_side(columns, ("x", "y", "z"))
    if points is None:
        raise InputError(f"has no fields x y z, but {' '.join(columns) or 'none'}")
    normals = side_by_side(columns, ("normal_x", "normal_y", "normal_z"))
    return FileShape(points, normals_xyz=normals)


def parse_pcd_header(data: bytes) -> PcdHeader:
    """Read the header at the beginning of `data`.

    Raises:
        InputError: Not a PCD file, or a header that is broken.
    """
    entries: dict[str, list[str]] = {}
    offset = 0
    while "DATA" not in entries:
        end = data.find(b"\n", offset)
        if end < 0 or len(entries) > 20:
            raise InputError("is not a PCD file, or is truncated: its header has no DATA line")
        words = data[offset:end].decode("latin-1").partition("#")[0].split()
        if words:
            entries[words[0].upper()] = words[1:]
        offset = end + 1
    try:
        return PcdHeader(_fields(entries), _points(entries), entries["DATA"][0].lower(), offset)
    except (ValueError, IndexError, KeyError) as error:
        raise InputError(f"is a PCD file with a broken header ({error})") from error


def _fields(entries: dict[str, list[str]]) -> tuple[tuple[str, str, int], ...]:
    names = entries["FIELDS"] if "FIELDS" in entries else entries["COLUMNS"]
    if len(names) > MAX_FIELDS:
        raise ValueError(f"{len(names)} fields")
    counts = [int(word) for word in entries.get("COUNT", ["1"] * len(names))]
    if entries["DATA"][0].lower() == "ascii":
        # Version .5 has neither TYPE nor SIZE, and numbers in text need none.
        entries = {"TYPE": ["F"] * len(names), "SIZE": ["4"] * len(names), **entries}
    types = [
        _TYPES[kind.upper(), int(size)]
        for kind, size in zip(entries["TYPE"], entries["SIZE"], strict=True)
    ]
    if min(counts, default=1) < 0 or max(counts, default=0) > 10_000:
        raise ValueError(f"COUNT {max(counts)}")
    # Padding is named "_", possibly several times.
    return tuple(zip(unique_names(names), types, counts, strict=True))


def _points(entries: dict[str, list[str]]) -> int:
    if "POINTS" in entries:
        points = int(entries["POINTS"][0])
    else:
        points = int(entries["WIDTH"][0]) * int(entries["HEIGHT"][0])
    if points < 0:
        raise ValueError("negative number of points")
    return points


def _decode_ascii(data: bytes, header: PcdHeader) -> dict[str, NDArray[Any]]:
    width = sum(count for _, _, count in header.fields)
    stream = io.BytesIO(data)
    stream.seek(header.size)
    table = read_table(stream, rows=header.points, columns=width)
    columns, position = {}, 0
    for name, _, count in header.fields:
        columns[name] = table[:, position] if count == 1 else table[:, position : position + count]
        position += count
    return columns


def _decode_binary(data: bytes, header: PcdHeader) -> dict[str, NDArray[Any]]:
    row = np.dtype([_sub(field) for field in header.fields])
    _require(header.size + header.points * row.itemsize, len(data), header)
    table = np.frombuffer(data, row, header.points if row.itemsize else 0, header.size)
    return {name: table[name] for name, _, _ in header.fields}


def _decode_compressed(data: bytes, header: PcdHeader) -> dict[str, NDArray[Any]]:
    """All values of a field are contiguous, and the whole is compressed."""
    _require(header.size + 8, len(data), header)
    packed_size, size = np.frombuffer(data, "<u4", 2, header.size).tolist()
    start = header.size + 8
    _require(start + packed_size, len(data), header)
    if size > max(UNCHECKED_BYTES, MAX_UNPACKING_RATIO * packed_size):
        raise InputError(
            f"would unpack from {packed_size >> 10} KiB to {size >> 20} MiB; no measured data do, "
            "so it is not read"
        )
    unpacked = _unpacked(data[start : start + packed_size], size)
    columns, offset = {}, 0
    for field in header.fields:
        item = np.dtype([_sub(field)])
        _require(offset + header.points * item.itemsize, len(unpacked), header)
        table = np.frombuffer(unpacked, item, header.points if item.itemsize else 0, offset)
        columns[field[0]] = table[field[0]]
        offset += header.points * item.itemsize
    return columns


def _unpacked(packed: bytes, size: int) -> bytes:
    try:
        return decompress_lzf(packed, size)
    except InputError:
        if len(packed) != size:
            raise
        return packed  # Data that do not get smaller are stored by some programs as they are.


def _sub(field: tuple[str, str, int]) -> tuple[Any, ...]:
    name, kind, count = field
    return (name, kind) if count == 1 else (name, kind, (count,))


def _require(needed: int, found: int, header: PcdHeader) -> None:
    if needed > found:
        raise InputError(
            f"ends too early: {header.points} points need {needed} bytes, {found} found; "
            "it may be truncated"
        )


_DECODERS = {
    "ascii": _decode_ascii,
    "binary": _decode_binary,
    "binary_compressed": _decode_compressed,
}


def decompress_lzf(packed: bytes, size: int) -> bytes:
    """Unpack `packed` to `size` bytes.

    Raises:
        InputError: The data are broken or do not unpack to that size.
    """
    if size > _MAX_RUN_BYTES * len(packed):
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
