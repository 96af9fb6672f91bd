"""NPY and NPZ: points as NumPy arrays, never a pickle."""

from __future__ import annotations

import math
import os
import threading
import warnings
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.file_shape import FileShape

POINT_KEYS = ("points_xyz", "points", "xyz")
NORMAL_KEYS = ("normals_xyz", "normals")

_LARGEST_DEFLATE_RATIO = 1032
_HEADER_READERS = {
    (1, 0): npy_format.read_array_header_1_0,
    (2, 0): npy_format.read_array_header_2_0,
}
# Warning filters belong to the whole process: one thread at a time.
_ALONE = threading.Lock()
_NPZ_FAULTS = (
    ValueError, KeyError, EOFError, OverflowError, RuntimeError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def read_npy(path: Path) -> FileShape:
    """Read an array of shape (n, 3) or wider, the first three columns being x, y, z.

    Raises:
        InputError: Not such an array.
    """
    try:
        with path.open("rb") as stream:
            return FileShape(_points(_array(stream, path.stat().st_size), "the array"))
    except ValueError as error:
        raise InputError(f"is no readable NPY file ({_reason(error)}); save it again") from error


def read_npz(path: Path) -> FileShape:
    """Read the array `points_xyz`, `points` or `xyz`, or the only one of shape (n, 3).

    Raises:
        InputError: Not an NPZ file, or it holds no such array.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            members = {
                item.filename.removesuffix(".npy"): item
                for item in archive.infolist()
                if item.filename.endswith(".npy")
            }
            points = _points(*_chosen_array(archive, members))
            normals = [_member(archive, members[key]) for key in NORMAL_KEYS if key in members]
            fitting = [array for array in normals if array.shape == points.shape]
            return FileShape(points, normals_xyz=_points(fitting[0], "") if fitting else None)
    except _NPZ_FAULTS as error:
        raise InputError(f"is no readable NPZ file ({_reason(error)}); save it again") from error


def read_arrays(path: str | os.PathLike[str], largest: int) -> dict[str, NDArray[Any]]:
    """Read all arrays of an NPZ file that another program may have made.

    Args:
        path: The file.
        largest: Bytes that all arrays together may take.

    Returns:
        Name to array of numbers.

    Raises:
        InputError: Missing, not an NPZ file, too large, or it holds something but numbers.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            items = archive.infolist()
            if sum(item.file_size for item in items) > largest:
                raise InputError(f"{path}: holds more than {largest >> 20} MB; is it another file?")
            return {item.filename.removesuffix(".npy"): _member(archive, item) for item in items}
    except InputError as error:
        raise InputError(str(error) if str(path) in str(error) else f"{path}: {error}") from error
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}") from error
    except _NPZ_FAULTS as error:
        raise InputError(f"{path}: is no readable NPZ file ({_reason(error)})") from error


def _chosen_array(
    archive: zipfile.ZipFile, members: dict[str, zipfile.ZipInfo]
) -> tuple[NDArray[Any], str]:
    for key in POINT_KEYS:
        if key in members:
            return _member(archive, members[key]), key
    arrays = {key: _member(archive, item) for key, item in members.items()}
    fitting = [key for key, array in arrays.items() if array.ndim == 2 and array.shape[1] == 3]
    if len(fitting) != 1:
        raise InputError(
            f"holds {len(fitting)} arrays of shape (n, 3) and none named "
            f"{', '.join(POINT_KEYS)}; it has: {', '.join(members) or 'no arrays'}"
        )
    return arrays[fitting[0]], fitting[0]


def _member(archive: zipfile.ZipFile, item: zipfile.ZipInfo) -> NDArray[Any]:
    if item.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise InputError("is packed in a way that NumPy never does; save it again")
    largest = min(item.file_size, item.compress_size * _LARGEST_DEFLATE_RATIO)
    with archive.open(item) as stream:
        return _array(stream, largest)


def _array(stream: IO[bytes], largest: int) -> NDArray[Any]:
    """The array in a stream of at most `largest` bytes; what its header says is not trusted."""
    shape, fortran_order, dtype = _header(stream)
    count = math.prod(shape)
    if dtype.kind not in "fiu":
        raise InputError(f"holds an array of {dtype}, not of numbers")
    if min(shape, default=0) < 0 or count * dtype.itemsize > largest:
        raise InputError(f"ends too early: shape {shape} announced, {largest} bytes found")
    array = np.frombuffer(stream.read(count * dtype.itemsize), dtype)
    if len(array) < count:
        raise InputError(f"ends too early: shape {shape} announced, {len(array)} numbers found")
    return array.reshape(shape, order="F" if fortran_order else "C")


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Shape, whether Fortran's order, and type."""
    version = npy_format.read_magic(stream)
    if version not in _HEADER_READERS:
        raise ValueError(f"version {version} of the format is unknown")
    with _ALONE, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return _HEADER_READERS[version](stream)
        except Exception as error:  # It is parsed as Python, so that anything may come up.
            raise ValueError(f"broken header: {_reason(error)}") from error


def _points(array: NDArray[Any], name: str) -> NDArray[np.float64]:
    if array.ndim != 2 or array.shape[1] < 3:
        raise InputError(f"{name} must have shape (n, 3) or wider, not {array.shape}")
    return array[:, :3].astype(np.float64, order="C")


def _reason(error: BaseException) -> str:
    return str(error).partition("\n")[0] or type(error).__name__
