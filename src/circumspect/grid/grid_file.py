"""Occupancy grids on disk: an npz of packed bits and bounds, without pickle.

Keys: `version` (1,), `shape` (3,) int64; `centre_xyz` (3,) and one float64 (1,) for each further
number of the bounds; `occupied` and `free`: uint8, one bit a cell in C order, high bit first.
"""

from __future__ import annotations

import math
import os
import re
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import CircumspectError, InputError
from circumspect.geometry.formats.file_errors import reading_file
from circumspect.grid.grid_arguments import checked_shape
from circumspect.storage import atomic_open

Bounds = TypeVar("Bounds")
VERSION = 1
_COMMON = ("version", "shape", "centre_xyz", "occupied", "free")
# NumPy's header of a plain array; nothing else is accepted, and no code is executed.
_HEADER = re.compile(
    rb"\{'descr': '([^']{3})', 'fortran_order': (?:False|True), "
    rb"'shape': \((\d{1,10}),\), \} *\n"
)


def write_grid(
    path: str | os.PathLike[str],
    shape: tuple[int, int, int],
    centre_xyz: Sequence[float],
    numbers: Mapping[str, float],
    occupied: NDArray[np.bool_],
    free: NDArray[np.bool_],
) -> None:
    """Write a grid; see `OccupancyGrid.save`.

    Args:
        path: The file.
        shape: Cells along each axis.
        centre_xyz: (3,) [m].
        numbers: The other bounds.
        occupied: Of the shape.
        free: Of the shape.

    Raises:
        OutputError: The file cannot be written.
    """
    further: dict[str, Any] = {name: np.array([value]) for name, value in numbers.items()}
    with atomic_open(path, "wb") as stream:
        np.savez_compressed(
            stream,
            version=np.array([VERSION], dtype=np.int64),
            shape=np.array(shape, dtype=np.int64),
            centre_xyz=np.array(centre_xyz),
            occupied=np.packbits(occupied),
            free=np.packbits(free),
            **further,
        )


def read_grid(
    path: str | os.PathLike[str], kinds: Mapping[tuple[str, ...], Callable[..., Bounds]]
) -> tuple[Bounds, NDArray[np.uint8], NDArray[np.uint8]]:
    """Read a grid; see `OccupancyGrid.load`.

    Args:
        path: The file.
        kinds: Constructors of the bounds, by the names of their numbers beside shape and centre.

    Returns:
        The bounds, and which cells are occupied and which are free: 0 or 1, of the grid's shape.

    Raises:
        InputError: Missing, truncated, or not a grid.
    """
    with reading_file(path) as file, file.open("rb") as stream:
        try:
            with zipfile.ZipFile(stream) as archive:
                return _unpacked(archive, kinds)
        except zipfile.BadZipFile as error:
            raise InputError("not a grid file or truncated; save the grid again") from error
        except (InputError, OSError):
            raise
        except CircumspectError as error:
            raise InputError(str(error)) from error
        # Broken archives raise many exceptions: zlib.error, EOFError, NotImplementedError …
        except Exception as error:
            raise InputError("a broken grid file; save the grid again") from error


def holds_grid(path: str | os.PathLike[str]) -> bool:
    """Whether a file is an archive with the keys of a grid, intact or not."""
    try:
        # Reading a pipe would block.
        if not Path(path).is_file():
            return False
        with Path(path).open("rb") as stream, zipfile.ZipFile(stream) as archive:
            return {"occupied.npy", "free.npy", "shape.npy"} <= set(archive.namelist())
    # Broken archives raise many exceptions, see `read_grid`.
    except Exception:
        return False


def _unpacked(
    archive: zipfile.ZipFile, constructors: Mapping[tuple[str, ...], Callable[..., Bounds]]
) -> tuple[Bounds, NDArray[np.uint8], NDArray[np.uint8]]:
    keys = [name.removesuffix(".npy") for name in archive.namelist()]
    kinds = [names for names in constructors if sorted(keys) == sorted((*_COMMON, *names))]
    if not kinds:
        raise InputError(f"not a grid file: it holds {', '.join(sorted(keys)[:12]) or 'nothing'}")
    version = int(_array(archive, "version", np.int64, 1)[0])
    if version != VERSION:
        raise InputError(f"grid file of version {version}; this program reads {VERSION}")
    shape = checked_shape(_array(archive, "shape", np.int64, 3).tolist())
    centre = _array(archive, "centre_xyz", np.float64, 3)
    numbers = {name: float(_array(archive, name, np.float64, 1)[0]) for name in kinds[0]}
    occupied, free = (_bits(archive, name, shape) for name in ("occupied", "free"))
    if (occupied & free).any():
        raise InputError("some cells are both occupied and free; save the grid again")
    bounds = constructors[kinds[0]](shape=shape, centre_xyz=centre, **numbers)
    return bounds, occupied, free


def _bits(archive: zipfile.ZipFile, name: str, shape: tuple[int, int, int]) -> NDArray[np.uint8]:
    cells = math.prod(shape)
    packed = _array(archive, name, np.uint8, (cells + 7) // 8)
    bits = np.unpackbits(packed)
    if bits[cells:].any():
        raise InputError(f"{name} has bits beyond the last cell; save the grid again")
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
        # One byte more than expected: reading to the end makes zipfile check its sum.
        content = stream.read(length * expected.itemsize + 1)
    if len(content) != length * expected.itemsize:
        raise InputError(f"{name} has {len(content)} bytes, not {length * expected.itemsize}")
    return np.frombuffer(content, dtype=expected.newbyteorder("<")).astype(expected)
