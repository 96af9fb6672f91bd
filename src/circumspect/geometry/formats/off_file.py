"""OFF: the format of ModelNet and of the Geomview family."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.ignored_warnings import ignored_warnings
from circumspect.geometry.formats.number_table import read_table
from circumspect.geometry.formats.polygons import fan_triangles, fan_triangles_mixed

# The counts may follow the word on its own line, as in known broken files of ModelNet ("OFF123 456
# 0").
_HEADER = re.compile(rb"\s*(ST)?(C)?(N)?(4)?(n)?OFF(?![A-Z])", re.ASCII)
_COMMENT = re.compile(rb"#[^\r\n]*")


@dataclass(frozen=True)
class OffLayout:
    """Numbers of a vertex by the first word of the file.

    Attributes:
        coordinates: 3, or 4 where they are homogeneous (4OFF).
        others: Further numbers of normal, colour and texture.
    """

    coordinates: int
    others: int


def read_off(path: Path) -> FileShape:
    """Read vertices and faces; polygons become triangles, colours are ignored.

    Line breaks may differ from the format's examples.

    Raises:
        InputError: Not an ASCII OFF file, truncated, or broken.
        GeometryError: Faces that name vertices which do not exist.
    """
    data = _COMMENT.sub(b"", path.read_bytes().removeprefix(codecs.BOM_UTF8))
    header = _HEADER.match(data)
    if header is None:
        raise InputError("is not an OFF file: it does not begin with OFF; check the format")
    texture, colour, normal, homogeneous, dimension = header.groups()
    if dimension is not None:
        raise InputError("is an nOFF file of any dimension; save it as OFF")
    layout = OffLayout(
        4 if homogeneous else 3, 2 * bool(texture) + 4 * bool(colour) + 3 * bool(normal)
    )
    body = data[header.end() :]
    try:
        return _by_lines(body, layout)
    except InputError as error:
        # Files with other line breaks are rare, and their faces can not have colours.
        if (shape := _free_format(body, layout)) is None:
            raise
        del error
        return shape


def _by_lines(body: bytes, layout: OffLayout) -> FileShape:
    lines = [line for line in body.splitlines() if line and not line.isspace()]
    vertex_count, face_count = _counts(lines)
    lines = lines[1:]
    if len(lines) < vertex_count + face_count:
        raise InputError(
            f"ends too early: {vertex_count} vertices and {face_count} faces announced, "
            f"{len(lines)} lines found"
        )
    vertices = read_table(lines[:vertex_count], rows=vertex_count, columns=layout.coordinates)
    faces = _faces(lines[vertex_count:][:face_count], vertex_count)
    return FileShape(_cartesian(vertices), faces)


def _free_format(body: bytes, layout: OffLayout) -> FileShape | None:
    """The same regardless of line breaks; None if the numbers do not fit the counts."""
    with ignored_warnings():  # Numbers end where words begin, with a warning.
        try:
            numbers = np.fromstring(body.decode("latin-1"), sep=" ")
        except ValueError:
            return None
    if len(numbers) < 3 or not (numbers[:3] >= 0).all() or not (numbers[:3] < 2**40).all():
        return None
    vertex_count, face_count = (int(number) for number in numbers[:2])
    width = layout.coordinates + layout.others
    end = 3 + vertex_count * width
    if end > len(numbers):
        return None
    vertices = numbers[3:end].reshape(vertex_count, width)[:, : layout.coordinates]
    polygons = _polygons_in_a_row(numbers[end:], face_count)
    if polygons is None:
        return None
    return FileShape(_cartesian(vertices), fan_triangles_mixed(polygons, vertex_count))


def _polygons_in_a_row(
    numbers: NDArray[np.float64], count: int
) -> list[NDArray[np.float64]] | None:
    """Faces in sequence, each after its number of corners; None if they do not fit."""
    polygons, position = [], 0
    for _ in range(count):
        stated = numbers[position] if position < len(numbers) else np.nan
        if not 0 <= stated < len(numbers) - position:  # NaN and infinity are rejected, too.
            return None
        corners = int(stated)
        polygons.append(numbers[position + 1 : position + 1 + corners])
        position += 1 + corners
    return polygons if position == len(numbers) else None


def _cartesian(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) of (n, 3), or of homogeneous (n, 4)."""
    if vertices.shape[1] == 3:
        return np.ascontiguousarray(vertices)
    return vertices[:, :3] / vertices[:, 3:]


def _counts(lines: list[bytes]) -> tuple[int, int]:
    words = lines[0].split() if lines else []
    if words[:1] == [b"BINARY"]:
        raise InputError("is a binary OFF file; save it as ASCII OFF or as PLY")
    try:
        vertex_count, face_count = (int(word) for word in words[:2])
    except ValueError:
        raise InputError("is a broken OFF file: no counts of vertices and faces") from None
    if vertex_count < 0 or face_count < 0:
        raise InputError("is a broken OFF file: negative counts")
    return vertex_count, face_count


def _faces(lines: list[bytes], vertex_count: int) -> NDArray[np.int64]:
    first = lines[0].split()[0] if lines else b"0"
    # Nearly all files hold only triangles; others are read line by line.
    if first == b"3" and all(line.lstrip().startswith(b"3") for line in lines):
        table = read_table(lines, rows=len(lines), columns=4)
        if (table[:, 0] == 3).all():
            return fan_triangles(table[:, 1:], vertex_count)
    return fan_triangles_mixed(_polygons(lines), vertex_count)


def _polygons(lines: list[bytes]) -> Iterator[list[float]]:
    for line in lines:
        words = line.split()
        try:
            corners = int(words[0])
            polygon = [float(word) for word in words[1 : 1 + max(corners, 0)]]
        except ValueError:
            raise InputError(f"has a broken face: {line[:60]!r}") from None
        if len(polygon) != corners:
            raise InputError(f"has a face of {corners} corners that names {len(polygon)} vertices")
        yield polygon
