"""OBJ: vertices and faces; materials, textures, lines and curves are ignored."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.number_table import read_table
from circumspect.geometry.formats.polygons import fan_triangles, fan_triangles_mixed


def read_obj(path: Path) -> FileShape:
    """Read vertices, faces and, where there are no faces, a normal for each point.

    Raises:
        InputError: No vertices, or broken lines.
        GeometryError: Faces that name vertices which do not exist.
    """
    return parse_obj(path.read_bytes())


def parse_obj(data: bytes) -> FileShape:
    """The same from the bytes of a file.

    Raises:
        InputError: See `read_obj`.
        GeometryError: See `read_obj`.
    """
    lines = _lines(data)
    positions = [line[2:] for line in lines if line[:2] in (b"v ", b"v\t")]
    if not positions:
        raise InputError("is not an OBJ file with vertices: no line begins with v")
    points = read_table(positions, rows=len(positions), columns=3)
    faces = _faces(lines, len(points))
    directions = [line[3:] for line in lines if line[:3] in (b"vn ", b"vn\t")]
    normals = None
    if len(faces) == 0 and len(directions) == len(points):
        normals = read_table(directions, rows=len(directions), columns=3)
    return FileShape(points, faces, normals)


def _lines(data: bytes) -> list[bytes]:
    data = data.removeprefix(codecs.BOM_UTF8)
    if b"\\" in data:
        data = re.sub(rb"\\\r?\n", b" ", data)
    if b"#" in data:
        data = re.sub(rb"#[^\r\n]*", b"", data)
    return [line.strip() for line in data.splitlines()]


def _faces(lines: list[bytes], vertex_count: int) -> NDArray[np.int64]:
    faces, seen, relative = [], [], False
    vertices = 0
    for line in lines:
        if line[:2] in (b"v ", b"v\t"):
            vertices += 1
        elif line[:2] in (b"f ", b"f\t"):
            faces.append(re.sub(rb"/\S*", b"", line[2:]) if b"/" in line else line[2:])
            seen.append(vertices)
            relative = relative or b"-" in line
    corner_counts = {len(face.split()) for face in faces}
    if corner_counts == {3} and not relative:
        return fan_triangles(read_table(faces, rows=len(faces), columns=3) - 1, vertex_count)
    polygons = (_polygon(face, count) for face, count in zip(faces, seen, strict=True))
    return fan_triangles_mixed(polygons, vertex_count)


def _polygon(face: bytes, vertices_so_far: int) -> list[float]:
    """Indices from 0; negative ones count back from the last vertex before the face."""
    try:
        indices = [int(word) for word in face.split()]
        return [float(index - 1 if index >= 0 else vertices_so_far + index) for index in indices]
    except (ValueError, OverflowError):
        raise InputError(f"has a broken face: {face[:60]!r}") from None
