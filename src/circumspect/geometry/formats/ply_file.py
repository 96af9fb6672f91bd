"""PLY: meshes and clouds, ASCII and binary of both byte orders."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.file_shape import FileShape, side_by_side
from circumspect.geometry.formats.ply_header import parse_ply_header
from circumspect.geometry.formats.ply_rows import Columns, Polygons, ply_rows
from circumspect.geometry.formats.polygons import (
    fan_triangles,
    fan_triangles_mixed,
    strip_triangles,
)
from circumspect.geometry.given_shapes import as_cloud
from circumspect.geometry.point_cloud import PointCloud
from circumspect.storage import atomic_open

_POSITION = ("x", "y", "z")
_NORMAL = ("nx", "ny", "nz")
_AREA = "area"
_TYPES = {"<f8": "double", "<f4": "float", "<i4": "int", "|u1": "uchar"}
_USED = (*_POSITION, *_NORMAL, _AREA)
_INDEX_LISTS = ("vertex_indices", "vertex_index")
_RESTART = -1
"""Index that separates triangle strips in a list."""


def read_ply(path: Path) -> FileShape:
    """Read vertices (x y z, nx ny nz, area) and, where there are any, faces and triangle strips.

    Other properties, including lists, and other elements are ignored.

    Raises:
        InputError: Not a PLY file, truncated, or broken.
        GeometryError: Faces that name vertices which do not exist.
    """
    data = path.read_bytes()
    header = parse_ply_header(data)
    rows = ply_rows(data, header)
    vertices: Columns = {}
    polygons, strips = [], []
    for element in header.elements:
        wanted = _USED if element.name == "vertex" else ()
        lists = _INDEX_LISTS if element.name in ("face", "tristrips") else ()
        if element.has_lists:
            columns, found = rows.mixed(element, wanted, lists)
        else:
            columns, found = rows.scalars(element), []
        if element.name == "vertex":
            vertices = columns
        elif element.name == "face":
            polygons = found
        elif element.name == "tristrips":
            strips = found
    points = side_by_side(vertices, _POSITION)
    if points is None:
        raise InputError("is a PLY file without vertices x, y, z; nothing to read")
    faces = _triangles(polygons, len(points))
    if len(strips):
        faces = np.concatenate([faces, _strip_triangles(strips, len(points))])
    return FileShape(
        points,
        faces=faces,
        normals_xyz=side_by_side(vertices, _NORMAL),
        areas=vertices.get(_AREA),
    )


def write_ply(
    path: str | os.PathLike[str],
    cloud: PointCloud | ArrayLike,
    counts: Mapping[str, NDArray[np.integer]] | None = None,
) -> None:
    """Write a cloud as binary PLY (little endian, double), with its normals and areas.

    `read_cloud` reads the same numbers, except counts; other programs ignore the areas.

    Args:
        path: The file; it appears when complete.
        cloud: The points, or an (n, 3) array of them [m].
        counts: Name to (n,) whole numbers, for other programs.

    Raises:
        InputError: A mesh or a path in the place of points.
        GeometryError: No array of points, see `PointCloud`.
        OutputError: The file cannot be written.
    """
    cloud = as_cloud(cloud)
    columns: Columns = dict(zip(_POSITION, cloud.points_xyz.T, strict=True))
    if cloud.normals_xyz is not None:
        columns |= dict(zip(_NORMAL, cloud.normals_xyz.T, strict=True))
    if cloud.areas is not None:
        columns[_AREA] = cloud.areas
    table = {name: column.astype("<f8") for name, column in columns.items()}
    table |= {name: column.astype("<i4") for name, column in (counts or {}).items()}
    write_vertices(path, table)


def write_vertices(path: str | os.PathLike[str], columns: Mapping[str, NDArray[Any]]) -> None:
    """Write named columns of numbers as the vertices of a binary PLY file.

    Args:
        path: The file; it appears when complete.
        columns: Name to (n,) numbers of a type in `_TYPES`.

    Raises:
        OutputError: The file cannot be written.
    """
    count = len(next(iter(columns.values())))
    table = np.empty(count, dtype=[(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {count}",
        *(f"property {_TYPES[column.dtype.str]} {name}" for name, column in columns.items()),
        "end_header",
    ]
    with atomic_open(path, "wb") as stream:
        stream.write(("\n".join(header) + "\n").encode("ascii"))
        stream.write(table.tobytes())


def _triangles(polygons: Polygons, vertex_count: int) -> NDArray[np.int64]:
    if isinstance(polygons, np.ndarray):
        return fan_triangles(polygons, vertex_count)
    return fan_triangles_mixed(polygons, vertex_count)


def _strip_triangles(strips: Polygons, vertex_count: int) -> NDArray[np.int64]:
    triangles = [strip_triangles(np.asarray(strip, np.float64), _RESTART) for strip in strips]
    return fan_triangles(np.concatenate(triangles), vertex_count)


def write_coloured_ply(
    path: str | os.PathLike[str],
    cloud: PointCloud,
    colours_rgb: NDArray[np.uint8],
    value: NDArray[np.floating],
    name: str = "value",
) -> None:
    """Write points with colours and one value each as binary PLY.

    `read_cloud` reads the points and ignores the rest.

    Args:
        path: The file; it appears when complete.
        cloud: n points [m].
        colours_rgb: (n, 3) uint8.
        value: (n,); written as float.
        name: Of the value.

    Raises:
        InputError: Colours or values that are not one per point.
        OutputError: The file cannot be written.
    """
    count = len(cloud)
    if colours_rgb.shape != (count, 3) or value.shape != (count,):
        raise InputError(
            f"{count} points need as many colours and values, not {colours_rgb.shape} and "
            f"{value.shape}"
        )
    places = {axis: cloud.points_xyz[:, i].astype("<f8") for i, axis in enumerate("xyz")}
    colours = {c: colours_rgb[:, i] for i, c in enumerate(("red", "green", "blue"))}
    write_vertices(path, {**places, **colours, name: value.astype("<f4")})
