"""Read clouds and meshes of many formats, which are detected by content and suffix."""

from __future__ import annotations

import codecs
import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.e57_file import read_e57
from circumspect.geometry.formats.file_errors import reading_file
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.gltf_file import read_gltf
from circumspect.geometry.formats.las_file import read_las
from circumspect.geometry.formats.numpy_file import read_npy, read_npz
from circumspect.geometry.formats.obj_file import read_obj
from circumspect.geometry.formats.off_file import read_off
from circumspect.geometry.formats.pcd_file import read_pcd
from circumspect.geometry.formats.ply_file import read_ply
from circumspect.geometry.formats.ptx_file import begins_as_ptx, read_ptx
from circumspect.geometry.formats.stl_file import read_stl
from circumspect.geometry.formats.usd_file import read_usd
from circumspect.geometry.formats.xyz_file import read_pts, read_xyz
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.triangle_mesh import TriangleMesh
from circumspect.plugins import Registry, cause_of, kind_of


class PluginReader:
    """Calls a third-party reader; its exceptions become an `InputError`."""

    def __init__(self, name: str, read: Callable[[Path], Any]) -> None:
        """Wrap a reader.

        Args:
            name: The requested name.
            read: From a path to a `PointCloud`, a `TriangleMesh`, or an (n, 3) array of points.
        """
        self._name, self._read = name, read

    def __call__(self, path: Path) -> FileShape:
        """The content of the file.

        Raises:
            InputError: The reader fails, or returns something else.
        """
        try:
            return _shape(self._read(path))
        except InputError as error:
            raise type(error)(f"reader '{self._name}': {error}") from error
        except OSError:
            raise
        # Third-party code may raise anything on a broken file.
        except Exception as error:
            raise InputError(f"reader '{self._name}' fails: {cause_of(error)}") from error


def checked_reader(name: str, value: Any) -> PluginReader:
    """Check that the object of a plug-in can be called.

    Raises:
        InputError: It cannot.
    """
    if not callable(value):
        raise InputError(f"{kind_of(value)}; a function of a path is needed")
    return PluginReader(name, value)


def _shape(read: Any) -> FileShape:
    if isinstance(read, TriangleMesh):
        return FileShape(np.array(read.vertices_xyz, np.float64), np.array(read.faces, np.int64))
    if isinstance(read, np.ndarray):
        read = PointCloud(read)
    if isinstance(read, PointCloud):
        normals = None if read.normals_xyz is None else np.array(read.normals_xyz, np.float64)
        areas = None if read.areas is None else np.array(read.areas, np.float64)
        return FileShape(np.array(read.points_xyz, np.float64), None, normals, areas)
    raise InputError(f"what it returns {kind_of(read)}; a PointCloud or a TriangleMesh is needed")


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
"""Suffixes of formats in metres, or with a stated unit that is converted to metres."""
# First bytes of files that identify the format better than the name.
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
_MAX_MEMBERS_SHOWN = 3


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
        samples: Number of points to draw from a mesh, evenly by area. Point clouds are kept whole.
        seed: Of the samples.
        reader: Name of a plug-in reader, or MODULE:NAME of one, for a file of any suffix.

    Returns:
        The cloud in the unit of the file, with normals where the file or its faces give them.
        Points that a scanner marked as missing (NaN, or the origin, see `missing_points`) are left
        out; a warning in the log counts them.

    Raises:
        InputError: The file cannot be read; the message names it and what to do.
        GeometryError: It was read, but holds no usable shape.
    """
    if samples < 1:
        raise InputError(f"samples must be at least 1, not {samples}")
    _require_axis(up)
    with reading_file(path) as file:
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
        InputError: The file cannot be read; the message names it and what to do.
        GeometryError: It was read, but holds no faces, or broken ones.
    """
    _require_axis(up)
    with reading_file(path) as file:
        shape = _reader(file, reader)(file)
        return shape.mesh(_ROTATION_TO_Z_UP[up or shape.up])


def read_surface(path: str | os.PathLike[str], up: str | None = None) -> TriangleMesh | PointCloud:
    """Read a file, z up: a triangle mesh, or a point cloud if it has no faces.

    Args:
        path: A file of one of the formats in `READERS`.
        up: The axis that points up in the file, as in `read_cloud`.

    Raises:
        InputError: The file cannot be read; the message names it and what to do.
        GeometryError: It was read, but holds no usable shape.
    """
    _require_axis(up)
    with reading_file(path) as file:
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
        # PowerShell writes redirected output in UTF-16.
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


def format_of_zip(path: Path) -> str:
    """The suffix of the format that an archive holds: ".npz" or ".usdz".

    Raises:
        InputError: Another archive; the message says which.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names = [item.filename for item in archive.infolist()]
    except (zipfile.BadZipFile, ValueError, OverflowError, NotImplementedError) as error:
        if path.suffix.lower() in (".npz", ".usdz"):
            return path.suffix.lower()  # Its reader says what is wrong.
        raise InputError(f"is a broken ZIP archive ({error}); copy it again") from error
    if path.suffix.lower() == ".npz" or any(name.endswith(".npy") for name in names):
        return ".npz"
    if names and names[0].lower().endswith((".usd", ".usda", ".usdc")):
        return ".usdz"
    if any(name.lower().endswith(".model") for name in names):
        raise InputError("is a 3MF file, which is not read; export it as STL, PLY or GLB")
    shown = ", ".join(names[:_MAX_MEMBERS_SHOWN]) or "nothing"
    others = f" and {len(names) - _MAX_MEMBERS_SHOWN} more" if len(names) > 3 else ""
    raise InputError(f"is a ZIP archive of {shown}{others}; unpack it first")
