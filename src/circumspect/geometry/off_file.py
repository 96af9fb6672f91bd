"""OFF: the format of ModelNet and of the Geomview family."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.file_shape import FileShape
from circumspect.geometry.number_table import read_table
from circumspect.geometry.polygons import fan_triangles, fan_triangles_mixed

# Texture, colour and normal columns may follow the coordinates; the counts may follow the word
# on its own line, as in the known faulty files of ModelNet ("OFF123 456 0").
_HEADER = re.compile(rb"\s*(?:ST)?C?N?OFF(?![A-Z])", re.ASCII)
_COMMENT = re.compile(rb"#[^\r\n]*")


def read_off(path: Path) -> FileShape:
    """Read vertices and faces; polygons become triangles, colours are passed over.

    Raises:
        InputError: Not an ASCII OFF file, truncated, or broken.
        GeometryError: Faces that name vertices which do not exist.
    """
    data = _COMMENT.sub(b"", path.read_bytes().removeprefix(codecs.BOM_UTF8))
    header = _HEADER.match(data)
    if header is None:
        raise InputError("is not an OFF file: it does not begin with OFF; check the format")
    lines = [line for line in data[header.end() :].splitlines() if line and not line.isspace()]
    vertex_count, face_count = _counts(lines)
    lines = lines[1:]
    if len(lines) < vertex_count + face_count:
        raise InputError(
            f"ends too early: {vertex_count} vertices and {face_count} faces announced, "
            f"{len(lines)} lines found"
        )
    vertices = read_table(lines[:vertex_count], rows=vertex_count, columns=3)
    return FileShape(vertices, _faces(lines[vertex_count:][:face_count], vertex_count))


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
    # Nearly all files hold triangles alone; the others are read line by line.
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
