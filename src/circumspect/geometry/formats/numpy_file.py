"""NPY and NPZ: points as NumPy arrays, never a pickle."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.npy_stream import (
    NPZ_ERRORS,
    NUMBERS,
    array_in,
    array_in_member,
    error_text,
    shape_in_member,
)
from circumspect.geometry.frozen_array import rows_of_fields

POINT_KEYS = ("points_xyz", "points", "xyz")
NORMAL_KEYS = ("normals_xyz", "normals")
MAX_CLOUD_COLUMNS = 16
"""Three rows with more columns than this are a transposed cloud."""
MAX_ARRAYS = 1000
"""Largest number of arrays in an archive without an array of a known name."""
MAX_COLUMNS = 64
"""Coordinates, colours and features of one point; an array with more is an image."""

# Includes structured arrays, which ROS and PCL use for points.
_KINDS, _WANTED = NUMBERS + "V", "numbers"


def read_npy(path: Path) -> FileShape:
    """Read an array of shape (n, 3) or wider, the first three columns or fields x, y, z.

    Raises:
        InputError: Not such an array.
    """
    try:
        with path.open("rb") as stream:
            return FileShape(
                _points(array_in(stream, path.stat().st_size, _KINDS, _WANTED), "the array")
            )
    except ValueError as error:
        raise InputError(f"is no readable NPY file ({error_text(error)}); save it again") from error


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
            normals = [
                array_in_member(archive, members[key]) for key in NORMAL_KEYS if key in members
            ]
            fitting = [array for array in normals if array.shape == points.shape]
            return FileShape(points, normals_xyz=_points(fitting[0], "") if fitting else None)
    except NPZ_ERRORS as error:
        raise InputError(f"is no readable NPZ file ({error_text(error)}); save it again") from error


def _chosen_array(
    archive: zipfile.ZipFile, members: dict[str, zipfile.ZipInfo]
) -> tuple[NDArray[Any], str]:
    for key in POINT_KEYS:
        if key in members:
            return array_in_member(archive, members[key], _KINDS, _WANTED), key
    if len(members) > MAX_ARRAYS:
        raise InputError(f"holds {len(members)} arrays and none named {', '.join(POINT_KEYS)}")
    shapes = {key: shape_in_member(archive, item) for key, item in members.items()}
    fitting = [key for key, shape in shapes.items() if len(shape) == 2 and shape[1] == 3]
    if len(fitting) != 1:
        raise InputError(
            f"holds {len(fitting)} arrays of shape (n, 3) and none named "
            f"{', '.join(POINT_KEYS)}; it has: {', '.join(members) or 'no arrays'}"
        )
    return array_in_member(archive, members[fitting[0]]), fitting[0]


def _points(array: NDArray[Any], name: str) -> NDArray[np.float64]:
    array = np.asarray(rows_of_fields(array))
    if array.ndim != 2 or array.shape[1] < 3:
        raise InputError(f"{name} must have shape (n, 3) or wider, not {array.shape}")
    if array.shape[0] == 3 and array.shape[1] > MAX_CLOUD_COLUMNS:
        raise InputError(f"{name} has shape {array.shape}; points are rows: save its transpose")
    if array.shape[1] > MAX_COLUMNS:
        raise InputError(
            f"{name} has shape {array.shape}; a row is a point, of at most {MAX_COLUMNS} numbers. "
            "If it is a depth image: circumspect replay takes folders of them"
        )
    return array[:, :3].astype(np.float64, order="C")
