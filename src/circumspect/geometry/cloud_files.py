"""Clouds and meshes from files of many formats, told apart by content and suffix."""

from __future__ import annotations

import codecs
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.e57_file import read_e57
from circumspect.geometry.file_faults import blamed_on
from circumspect.geometry.file_shape import FileShape
from circumspect.geometry.gltf_file import read_gltf
from circumspect.geometry.las_file import read_las
from circumspect.geometry.numpy_file import read_npy, read_npz
from circumspect.geometry.obj_file import read_obj
from circumspect.geometry.off_file import read_off
from circumspect.geometry.pcd_file import read_pcd
from circumspect.geometry.plugin_reader import PluginReader, checked_reader
from circumspect.geometry.ply_file import read_ply
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.pts_file import read_pts
from circumspect.geometry.ptx_file import begins_as_ptx, read_ptx
from circumspect.geometry.stl_file import read_stl
from circumspect.geometry.triangle_mesh import TriangleMesh
from circumspect.geometry.usd_file import read_usd
from circumspect.geometry.xyz_file import read_xyz
from circumspect.geometry.zip_contents import format_of_zip
from circumspect.plugins import Registry

# Suffix -> reader. A new format is one line here.
READERS: dict[str, Callable[[Path], FileShape]] = {
    ".off": read_off,
    ".ply": read_ply,
    ".npy": read_npy,
    ".npz": read_npz,
    ".pcd": read_pcd,
    ".stl": read_stl,
    ".obj": read_obj,
    ".xyz": read_xyz,
    ".txt": read_xyz,
    ".csv": read_xyz,
    ".glb": read_gltf,
    ".gltf": read_gltf,
    ".pts": read_pts,
    ".asc": read_xyz,
    ".ptx": read_ptx,
    ".las": read_las,
    ".laz": read_las,
    ".e57": read_e57,
    ".usd": read_usd,
    ".usda": read_usd,
    ".usdc": read_usd,
    ".usdz": read_usd,
}

READER_REGISTRY: Registry[PluginReader] = Registry(
    "reader", "circumspect.readers", {}, checked_reader
)
"""Readers of other packages; an entry point is named after the suffix it reads, without the dot."""

METRIC_SUFFIXES = (".glb", ".gltf", ".e57", ".usd", ".usda", ".usdc", ".usdz")
"""Of formats whose unit is the metre, or that state theirs and are read in metres."""

# How a file begins, where that says more than its name.
_SIGNATURES = {
    b"ply\n": ".ply",
    b"ply\r": ".ply",
    b"OFF": ".off",
    b"4OFF": ".off",
    b"# .PCD": ".pcd",
    b"\x93NUMPY": ".npy",
    b"glTF": ".glb",
    b"PXR-USDC": ".usdc",
    b"#usda": ".usda",
    b"LASF": ".las",
    b"ASTM-E57": ".e57",
}
_ZIP = b"PK\x03\x04"
_TEXT_TABLES = (".xyz", ".txt", ".csv", ".pts", ".asc")

# The smallest rotation that turns the axis which points up in the file to z (right-handed).
_ROTATION_TO_Z_UP: dict[str, NDArray[np.float64]] = {
    "x": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "z": np.eye(3),
}


def read_cloud(
    path: str | os.PathLike[str],
    up: str | None = None,
    samples: int = 32768,
    seed: int = 0,
    reader: str | None = None,
) -> PointCloud:
    """Read the surface points of an object, z up.

    Args:
        path: A file of one of the formats in `READERS`.
        up: The axis that points up in the file: "x", "y" or "z". The points are turned by the
            smallest rotation that brings it to z: "y" gives (x, -z, y), "x" gives (-z, y, x).
            None takes the convention of the format: y for glTF and GLB, what USD files say, and z
            for all others.
        samples: How many points to draw from a mesh, evenly by area. Mere points are all kept.
        seed: Of the draw.
        reader: Name of a plug-in reader, or MODULE:NAME of one, for a file of any suffix.

    Returns:
        The cloud in the unit of the file, with normals where the file or its faces give them.
        Points that a scanner marked as missing (NaN, or the origin, see `missing_points`) are left
        out; a warning in the log counts them.

    Raises:
        InputError: The file can not be read; the message names it and what to do.
        GeometryError: It was read, but holds no usable shape.
    """
    if samples < 1:
        raise InputError(f"samples must be at least 1, not {samples}")
    _require_axis(up)
    with blamed_on(path) as file:
        shape = _reader(file, reader)(file)
        rotation = _ROTATION_TO_Z_UP[up or shape.up]
        if shape.has_faces:
            return shape.mesh(rotation).sampled(samples, np.random.default_rng(seed))
        return shape.cloud(rotation)


def read_mesh(
    path: str | os.PathLike[str], up: str | None = None, reader: str | None = None
) -> TriangleMesh:
    """Read a surface of triangles, z up; polygons are cut into triangles.

    Args:
        path: A file of one of the formats in `READERS`.
        up: The axis that points up in the file, as in `read_cloud`.
        reader: As in `read_cloud`.

    Raises:
        InputError: The file can not be read; the message names it and what to do.
        GeometryError: It was read, but holds no faces, or broken ones.
    """
    _require_axis(up)
    with blamed_on(path) as file:
        shape = _reader(file, reader)(file)
        return shape.mesh(_ROTATION_TO_Z_UP[up or shape.up])


def read_surface(path: str | os.PathLike[str], up: str | None = None) -> TriangleMesh | PointCloud:
    """Read what a file holds, z up: a surface of triangles, or points where it has no faces.

    Args:
        path: A file of one of the formats in `READERS`.
        up: The axis that points up in the file, as in `read_cloud`.

    Raises:
        InputError: The file can not be read; the message names it and what to do.
        GeometryError: It was read, but holds no usable shape.
    """
    _require_axis(up)
    with blamed_on(path) as file:
        shape = _reader(file, None)(file)
        rotation = _ROTATION_TO_Z_UP[up or shape.up]
        return shape.mesh(rotation) if shape.has_faces else shape.cloud(rotation)


def _require_axis(up: str | None) -> None:
    if up is not None and up not in _ROTATION_TO_Z_UP:
        raise InputError(f"up must be x, y or z, not {up!r}")


def _reader(path: Path, plugin: str | None) -> Callable[[Path], FileShape]:
    if plugin is not None:
        return READER_REGISTRY.get(plugin)
    with path.open("rb") as stream:
        head = stream.read(16)
    if not head:
        raise InputError("is empty; save or download it again")
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        # PowerShell writes what goes through its `>` so.
        raise InputError("is text in UTF-16; save it as UTF-8 or ASCII")
    signed = (suffix for mark, suffix in _SIGNATURES.items() if head.startswith(mark))
    suffix = next(signed, path.suffix.lower())
    if head.startswith(_ZIP):
        suffix = format_of_zip(path)
    elif suffix in _TEXT_TABLES and begins_as_ptx(path):
        suffix = ".ptx"
    if suffix not in READERS:
        name = suffix.removeprefix(".")
        if (reader := READER_REGISTRY.find(name, reference=False)) is not None:
            return reader
        known = " ".join(sorted({*READERS, *(f".{name}" for name in READER_REGISTRY.names())}))
        raise InputError(f"unknown format {path.suffix or '(no suffix)'!r}; known: {known}")
    return READERS[suffix]
