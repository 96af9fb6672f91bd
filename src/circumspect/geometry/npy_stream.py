"""Arrays in NPY's format within files, read without trust: never a pickle, never a bomb."""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Collection, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.file_faults import blamed_on
from circumspect.geometry.ignored_warnings import ignored_warnings

NUMBERS = "fiu"
WORDS = {NUMBERS: "numbers", "iu": "whole numbers", "f": "fractions (float)", "U": "text (str)"}
"""What values of some kinds are, for the one who saved others."""
NPZ_FAULTS = (
    ValueError, KeyError, EOFError, OverflowError, RuntimeError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What broken archives raise."""
MOST_BYTES = 2 << 30
"""Of all arrays that are read from one archive."""
HARMLESS_BYTES = 64 << 20
MOST_UNPACKED = 64
"""Zeros pack a thousandfold, measurements do not: a larger array may not be so many times as large
as it was packed."""

_LARGEST_DEFLATE_RATIO = 1032
_HEADER_READERS = {
    (1, 0): npy_format.read_array_header_1_0,
    (2, 0): npy_format.read_array_header_2_0,
}


def read_arrays(
    path: Path,
    kinds: Mapping[str, str],
    most_bytes: int = MOST_BYTES,
    optional: Collection[str] = (),
    wanted: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, NDArray[Any]]:
    """Read arrays of known names from an NPZ file; others in it are not looked at.

    Args:
        path: The file.
        kinds: Names to NumPy's letters for the kinds of values that each may hold.
        most_bytes: Of all arrays together.
        optional: Those of the names that the file may lack.
        wanted: Names to what else than `WORDS` is said of an array of another kind.

    Raises:
        InputError: The file is missing or broken, lacks an array, holds one of another kind, or
            more than is meant to be.
    """
    try:
        with (
            blamed_on(path) as file,
            file.open("rb") as stream,
            zipfile.ZipFile(stream) as archive,
        ):
            all_members = {item.filename: item for item in archive.infolist()}
            members = {
                name: all_members[f"{name}.npy"] for name in kinds if f"{name}.npy" in all_members
            }
            if missing := [name for name in kinds if name not in members and name not in optional]:
                raise InputError(f"lacks {', '.join(missing)}")
            size = sum(item.file_size for item in members.values())
            if size > most_bytes:
                raise InputError(f"would unpack to {size >> 20} MiB; {most_bytes >> 20} are read")
            return {
                name: array_in_member(archive, item, kinds[name], wanted.get(name))
                for name, item in members.items()
            }
    except NPZ_FAULTS as error:
        raise InputError(f"{path}: no readable NPZ file ({told(error)})") from error


def array_in_member(
    archive: zipfile.ZipFile,
    item: zipfile.ZipInfo,
    kinds: str = NUMBERS,
    wanted: str | None = None,
) -> NDArray[Any]:
    """One array of an NPZ file.

    Args:
        archive: The file.
        item: The array in it.
        kinds: See `array_in`.
        wanted: See `array_in`.

    Raises:
        InputError: Packed otherwise than NumPy does, too large, or see `array_in`; it names the
            array.
        ValueError: No NPY file; see `NPZ_FAULTS` for what else.
    """
    try:
        return _unpacked(archive, item, kinds, wanted)
    except InputError as error:
        raise InputError(f"{item.filename.removesuffix('.npy')} {error}") from error


def _unpacked(
    archive: zipfile.ZipFile, item: zipfile.ZipInfo, kinds: str, wanted: str | None
) -> NDArray[Any]:
    if item.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise InputError("is packed in a way that NumPy never does; save it again")
    if item.file_size > max(HARMLESS_BYTES, MOST_UNPACKED * item.compress_size):
        raise InputError(
            f"would unpack from {item.compress_size >> 10} KiB to {item.file_size >> 20} MiB; "
            "no measured data do, so it is not read"
        )
    largest = min(item.file_size, item.compress_size * _LARGEST_DEFLATE_RATIO)
    with archive.open(item) as stream:
        return array_in(stream, largest, kinds, wanted)


def shape_in_member(archive: zipfile.ZipFile, item: zipfile.ZipInfo) -> tuple[int, ...]:
    """The shape of an array of an NPZ file, which is not read.

    Raises:
        ValueError: No NPY file; see `NPZ_FAULTS` for what else.
    """
    with archive.open(item) as stream:
        return _header(stream)[0]


def array_in(
    stream: IO[bytes], largest: int, kinds: str = NUMBERS, wanted: str | None = None
) -> NDArray[Any]:
    """The array in a stream; what its header says is not trusted.

    Args:
        stream: At the beginning of an NPY file.
        largest: Bytes that the stream can hold.
        kinds: NumPy's letters for the kinds of values that are taken.
        wanted: What is said of others that they are not; None takes the words for the kinds.

    Raises:
        InputError: Values of another kind, or fewer than announced.
        ValueError: No NPY file.
    """
    shape, fortran_order, dtype = _header(stream)
    if not all(type(length) is int for length in shape):  # True is an int to NumPy's check.
        raise ValueError(f"shape {shape} is not of whole numbers")
    count = math.prod(shape)
    if dtype.kind not in kinds:
        raise InputError(f"holds an array of {dtype}, not of {wanted or WORDS.get(kinds, kinds)}")
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
    with ignored_warnings():
        try:
            return _HEADER_READERS[version](stream)
        except Exception as error:  # It is parsed as Python, so that anything may come up.
            raise ValueError(f"broken header: {told(error)}") from error


def told(error: BaseException) -> str:
    """The first line of what an exception says."""
    return str(error).partition("\n")[0] or type(error).__name__
