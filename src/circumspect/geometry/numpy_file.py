"""NPY and NPZ: points as NumPy arrays, never a pickle."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.file_shape import FileShape

POINT_KEYS = ("points_xyz", "points", "xyz")


def read_npy(path: Path) -> FileShape:
    """Read an array of shape (n, 3) or wider, the first three columns being x, y, z.

    Raises:
        InputError: Not such an array.
    """
    try:
        return FileShape(_points(np.load(path, allow_pickle=False, mmap_mode="r"), "the array"))
    except (ValueError, TypeError, SyntaxError, EOFError) as error:
        raise InputError(
            f"is no readable NPY file ({_first_line(error)}); save it again"
        ) from error


def read_npz(path: Path) -> FileShape:
    """Read the array `points_xyz`, `points` or `xyz`, or the only one of shape (n, 3).

    Raises:
        InputError: Not an NPZ file, or it holds no such array.
    """
    try:
        with np.load(path, allow_pickle=False) as arrays:
            key = _chosen(arrays)
            normals = arrays.get("normals_xyz")
            return FileShape(_points(arrays[key], key), normals_xyz=normals)
    except (ValueError, TypeError, SyntaxError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(
            f"is no readable NPZ file ({_first_line(error)}); save it again"
        ) from error


def _chosen(arrays: Mapping[str, Any]) -> str:
    for key in POINT_KEYS:
        if key in arrays:
            return key
    fitting = [key for key in arrays if arrays[key].ndim == 2 and arrays[key].shape[1] == 3]
    if len(fitting) != 1:
        raise InputError(
            f"holds {len(fitting)} arrays of shape (n, 3) and none named "
            f"{', '.join(POINT_KEYS)}; arrays: {', '.join(arrays) or 'none'}"
        )
    return fitting[0]


def _points(array: NDArray[Any], name: str) -> NDArray[np.float64]:
    if array.dtype.kind not in "fiu":
        raise InputError(f"{name} holds {array.dtype}, not numbers")
    if array.ndim != 2 or array.shape[1] < 3:
        raise InputError(f"{name} must have shape (n, 3) or wider, not {array.shape}")
    return np.array(array[:, :3], dtype=np.float64)


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0]
