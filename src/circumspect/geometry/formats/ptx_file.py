"""PTX: gridded scans in text, each after a header with its pose."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.number_table import read_table

MAX_SCANS = 1000
MAX_POINTS = 100_000_000
"""Largest number of points of all scans; a point's line has at least 7 bytes."""

# Behind the numbers of columns and rows: position, three axes, and a matrix of four rows.
_HEADER_WIDTHS = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
_MAX_LINE_LENGTH = 1000


def begins_as_ptx(path: Path) -> bool:
    """Whether a text file begins with a PTX header, regardless of its name."""
    with path.open("rb") as stream:
        lines = [stream.readline(_MAX_LINE_LENGTH) for _ in _HEADER_WIDTHS]
    return _header(lines) is not None


def read_ptx(path: Path) -> FileShape:
    """Read the points of all scans, in the common frame of their poses.

    Rays without a return, at (0, 0, 0) of their scan, are left out as missing.

    Raises:
        InputError: Not a PTX file, truncated, or with too many scans.
    """
    scans: list[NDArray[np.float64]] = []
    with path.open("rb") as stream:
        while (header := _next_header(stream)) is not None:
            count, matrix = header
            if len(scans) == MAX_SCANS or count > MAX_POINTS:
                raise InputError(f"has more than {MAX_SCANS} scans or {MAX_POINTS} points")
            points = read_table(_rows(stream, count), rows=None, columns=3)
            if len(points) < count:
                raise InputError(f"ends too early: {count} points announced, {len(points)} found")
            # Rows are multiplied from the left, so that the translation is the last row.
            placed = points @ matrix[:3, :3] + matrix[3, :3]
            placed[(points == 0).all(axis=1)] = np.nan
            scans.append(placed)
    if not scans:
        raise InputError("is not a PTX file: it has no header of ten lines")
    return FileShape(np.concatenate(scans))


def _rows(stream: IO[bytes], count: int) -> Iterator[bytes]:
    return islice(iter(stream.readline, b""), count)


def _next_header(stream: IO[bytes]) -> tuple[int, NDArray[np.float64]] | None:
    """Number of points and pose of the next scan; None at the end of the file."""
    lines = [stream.readline(_MAX_LINE_LENGTH) for _ in _HEADER_WIDTHS]
    if not b"".join(lines).strip():
        return None
    if (header := _header(lines)) is None:
        raise InputError("is a broken PTX file: a scan without a header of ten lines")
    return header


def _header(lines: list[bytes]) -> tuple[int, NDArray[np.float64]] | None:
    words = [line.split() for line in lines]
    if tuple(map(len, words)) != _HEADER_WIDTHS:
        return None
    try:
        columns, rows = int(words[0][0]), int(words[1][0])
        matrix = np.array([[float(word) for word in row] for row in words[6:]])
    except ValueError:
        return None
    return (columns * rows, matrix) if columns > 0 and rows > 0 else None
