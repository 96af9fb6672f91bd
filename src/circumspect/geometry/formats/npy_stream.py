"""Read untrusted arrays in NPY's format within files, without pickles and with bounded memory."""

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
from circumspect.geometry.formats.file_errors import reading_file
from circumspect.geometry.formats.ignored_warnings import ignored_warnings

NUMBERS = "fiu"
WORDS = {NUMBERS: "numbers", "iu": "whole numbers", "f": "fractions (float)", "U": "text (str)"}
"""Descriptions of the kinds of values, for error messages."""
NPZ_ERRORS = (
    ValueError, KeyError, EOFError, OverflowError, RuntimeError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""Exceptions for broken archives."""
MAX_BYTES = 2 << 30
"""Largest size of all arrays from one archive."""
UNCHECKED_BYTES = 64 << 20
MAX_UNPACKING_RATIO = 64
"""Largest ratio of unpacked to packed size for large arrays: zeros pack a thousandfold,
measurements do not."""

_MAX_DEFLATE_RATIO = 1032
_HEADER_READERS = {
    (1, 0): npy_format.read_array_header_1_0,
    (2, 0): npy_format.read_array_header_2_0,
}


def read_arrays(
    path: Path,
    kinds: Mapping[str, str],
    max_bytes: int = MAX_BYTES,
    optional: Collection[str] = (),
    wanted: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, NDArray[Any]]:
    """Read arrays of known names from an NPZ file; other arrays are ignored.

    Args:
        path: The file.
        kinds: Names to NumPy's letters for the kinds of values that each may hold.
        max_bytes: Largest size of all arrays together.
        optional: Names that the file may lack.
        wanted: Names to the expected content, for error messages; default `WORDS`.

    Raises:
        InputError: The file is missing, broken or too large, lacks an array, or holds one of
            another kind.
    """
    try:
        with (
            reading_file(path) as file,
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
            if size > max_bytes:
                raise InputError(f"would unpack to {size >> 20} MiB; {max_bytes >> 20} are read")
            return {
                name: array_in_member(archive, item, kinds[name], wanted.get(name))
                for name, item in members.items()
            }
    except NPZ_ERRORS as error:
        raise InputError(f"{path}: no readable NPZ file ({error_text(error)})") from error


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
        ValueError: No NPY file; see `NPZ_ERRORS` for what else.
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
    if item.file_size > max(UNCHECKED_BYTES, MAX_UNPACKING_RATIO * item.compress_size):
        raise InputError(
            f"would unpack from {item.compress_size >> 10} KiB to {item.file_size >> 20} MiB; "
            "no measured data do, so it is not read"
        )
    largest = min(item.file_size, item.compress_size * _MAX_DEFLATE_RATIO)
    with archive.open(item) as stream:
        return array_in(stream, largest, kinds, wanted)


def shape_in_member(archive: zipfile.ZipFile, item: zipfile.ZipInfo) -> tuple[int, ...]:
    """The shape of an array in an NPZ file, without reading the array.

    Raises:
        ValueError: No NPY file; see `NPZ_ERRORS` for what else.
    """
    with archive.open(item) as stream:
        return _header(stream)[0]


def array_in(
    stream: IO[bytes], largest: int, kinds: str = NUMBERS, wanted: str | None = None
) -> NDArray[Any]:
    """The array in a stream, whose header is not trusted.

    Args:
        stream: At the beginning of an NPY file.
        largest: Largest size of the stream [bytes].
        kinds: NumPy's letters for the accepted kinds of values.
        wanted: Expected content, for error messages; None means the description of the kinds.

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
    """Shape, whether in Fortran's order, and type."""
    version = npy_format.read_magic(stream)
    if version not in _HEADER_READERS:
        raise ValueError(f"version {version} of the format is unknown")
    with ignored_warnings():
        try:
            return _HEADER_READERS[version](stream)
        except Exception as error:  # It is parsed as Python, so that anything may come up.
            raise ValueError(f"broken header: {error_text(error)}") from error


def error_text(error: BaseException) -> str:
    """The first line of an exception's message."""
    return str(error).partition("\n")[0] or type(error).__name__
