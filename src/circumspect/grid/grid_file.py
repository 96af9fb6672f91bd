"""Occupancy grids on disk: an npz of packed bits and bounds, without pickle.

Keys: `version` (1,), `shape` (3,) int64; `centre_xyz` (3,) and one float64 (1,) for each further
number of the bounds; `occupied` and `free`: uint8, one bit a cell in C order, high bit first.
"""

from __future__ import annotations

import math
import os
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import CircumspectError, InputError
from circumspect.geometry.file_faults import blamed_on
from circumspect.grid.cylindrical_grid import CylindricalGrid
from circumspect.grid.grid_arguments import checked_shape
from circumspect.grid.occupancy_grid import FREE, OCCUPIED, OccupancyGrid
from circumspect.grid.rectangular_grid import RectangularGrid
from circumspect.storage import atomic_open

VERSION = 1
_KINDS: dict[type[Any], tuple[str, ...]] = {
    CylindricalGrid: ("radius", "half_height", "azimuth_offset"),
    RectangularGrid: ("half_width", "yaw"),
}
_COMMON = ("version", "shape", "centre_xyz", "occupied", "free")
# What numpy writes before the values of a plain array; nothing else is accepted, nothing is run.
_HEADER = re.compile(
    rb"\{'descr': '([^']{3})', 'fortran_order': (?:False|True), "
    rb"'shape': \((\d{1,10}),\), \} *\n"
)


def write_grid(path: str | os.PathLike[str], grid: OccupancyGrid) -> None:
    """Write a grid; see `OccupancyGrid.save`."""
    bounds = grid.grid
    numbers: dict[str, Any] = {
        name: np.array([getattr(bounds, name)]) for name in _KINDS[type(bounds)]
    }
    with atomic_open(path, "wb") as stream:
        np.savez_compressed(
            stream,
            version=np.array([VERSION], dtype=np.int64),
            shape=np.array(bounds.shape, dtype=np.int64),
            centre_xyz=np.array(bounds.centre_xyz),
            occupied=np.packbits(grid.states == OCCUPIED),
            free=np.packbits(grid.states == FREE),
            **numbers,
        )


def read_grid(path: str | os.PathLike[str]) -> OccupancyGrid:
    """Read a grid; see `OccupancyGrid.load`."""
    with blamed_on(path) as file, file.open("rb") as stream:
        try:
            with zipfile.ZipFile(stream) as archive:
                return _unpacked(archive)
        except zipfile.BadZipFile as error:
            raise InputError("not a grid file or truncated; save the grid anew") from error
        except (InputError, OSError):
            raise
        except CircumspectError as error:
            raise InputError(str(error)) from error
        # Broken archives raise many things: zlib.error, EOFError, NotImplementedError …
        except Exception as error:
            raise InputError("a broken grid file; save the grid anew") from error


def holds_grid(path: str | os.PathLike[str]) -> bool:
    """Whether a file is an archive with the keys of a grid, sound or not."""
    try:
        # A pipe would be waited for.
        if not Path(path).is_file():
            return False
        with Path(path).open("rb") as stream, zipfile.ZipFile(stream) as archive:
            return {"occupied.npy", "free.npy", "shape.npy"} <= set(archive.namelist())
    # Broken archives raise many things, see `read_grid`.
    except Exception:
        return False


def _unpacked(archive: zipfile.ZipFile) -> OccupancyGrid:
    keys = [name.removesuffix(".npy") for name in archive.namelist()]
    kinds = [kind for kind in _KINDS if sorted(keys) == sorted((*_COMMON, *_KINDS[kind]))]
    if not kinds:
        raise InputError(f"not a grid file: it holds {', '.join(sorted(keys)[:12]) or 'nothing'}")
    version = int(_array(archive, "version", np.int64, 1)[0])
    if version != VERSION:
        raise InputError(f"grid file of version {version}; this program reads {VERSION}")
    shape = checked_shape(_array(archive, "shape", np.int64, 3).tolist())
    centre = _array(archive, "centre_xyz", np.float64, 3)
    numbers = {name: float(_array(archive, name, np.float64, 1)[0]) for name in _KINDS[kinds[0]]}
    occupied, free = (_bits(archive, name, shape) for name in ("occupied", "free"))
    if (occupied & free).any():
        raise InputError("some cells are both occupied and free; save the grid anew")
    states = OCCUPIED * occupied + FREE * free
    return OccupancyGrid(kinds[0](shape=shape, centre_xyz=centre, **numbers), states)


def _bits(archive: zipfile.ZipFile, name: str, shape: tuple[int, int, int]) -> NDArray[np.uint8]:
    cells = math.prod(shape)
    packed = _array(archive, name, np.uint8, (cells + 7) // 8)
    bits = np.unpackbits(packed)
    if bits[cells:].any():
        raise InputError(f"{name} has bits beyond the last cell; save the grid anew")
    return bits[:cells].reshape(shape)


def _array(archive: zipfile.ZipFile, name: str, dtype: Any, length: int) -> NDArray[Any]:
    expected = np.dtype(dtype)
    with archive.open(f"{name}.npy") as stream:
        start = stream.read(10)
        if start[:8] != b"\x93NUMPY\x01\x00":
            raise InputError(f"{name} is not an array of numpy's first format")
        header = _HEADER.fullmatch(stream.read(int.from_bytes(start[8:10], "little")))
        if header is None:
            raise InputError(f"{name} must be an array of shape ({length},)")
        kind, count = header[1].decode("latin-1"), int(header[2])
        if (kind, count) != (expected.newbyteorder("<").str, length):
            raise InputError(
                f"{name} must be {expected} of shape ({length},), not {kind!r} of shape ({count},)"
            )
        # One byte more than wanted: reading to the end makes zipfile check its sum.
        content = stream.read(length * expected.itemsize + 1)
    if len(content) != length * expected.itemsize:
        raise InputError(f"{name} has {len(content)} bytes, not {length * expected.itemsize}")
    return np.frombuffer(content, dtype=expected.newbyteorder("<")).astype(expected)
