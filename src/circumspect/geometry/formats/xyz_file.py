"""XYZ, TXT, CSV and PTS: one point per line."""

from __future__ import annotations

import codecs
from collections import deque
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.column_titles import (
    FIRST_THREE,
    check_first_three,
    delimiter_of,
    is_number,
    named_columns,
    split,
)
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.number_table import read_table

# Largest number of title or count lines before the first point.
_LEADING_LINES = 10
# With fewer rows a column may be constant by chance.
_MIN_ROWS = 16
# Differences between steps of a time or an index are below this fraction.
_EVEN = 1e-3


def read_xyz(path: Path) -> FileShape:
    """Read x, y, z, separated by blanks, commas or semicolons.

    They are in the columns that a title names x, y and z, otherwise in the first three. Words
    before the first point, comments (# or //) and further columns are ignored.

    Raises:
        InputError: No table of numbers, or its titles name columns that are no coordinates.
    """
    with path.open("rb") as stream:
        columns, delimiter, titled = _skip_to_first_point(stream)
        lines = (text for line in stream if (text := _without_comment(line)))
        quote = '"' if delimiter else None
        points = read_table(lines, columns=columns, delimiter=delimiter, quote=quote)
    if columns == FIRST_THREE and not titled:
        require_coordinates_first(points, _width(path, delimiter))
    return FileShape(points)


def require_coordinates_first(points: NDArray[np.float64], width: int) -> None:
    """Refuse a first column that is constant or a running number, if others follow.

    Args:
        points: (n, 3) the first three columns of a table without titles.
        width: Number of columns of the table.

    Raises:
        InputError: The first column is a label, a time or an index, not x.
    """
    if width <= len(FIRST_THREE) or len(points) < _MIN_ROWS:
        return
    with np.errstate(invalid="ignore"):
        steps = np.diff(points[:, 0])
    even = np.abs(steps - steps[0]) <= _EVEN * np.abs(steps[0])
    if not even.all() or not (points[:, 1] != points[0, 1]).any():
        return
    kind = "constant" if steps[0] == 0 else "a running number"
    raise InputError(
        f"has {width} columns without titles, and the first one is {kind}, so that it is not x; "
        "put a line with their names first, as: label x y z"
    )


def _width(path: Path, delimiter: str | None) -> int:
    """Number of columns in the last row of a table."""
    with path.open("rb") as stream:
        stream.seek(-min(path.stat().st_size, 10_000), 2)
        rows = [row for line in stream if (row := _without_comment(line))]
    return len(split(_text(rows[-1]), delimiter)) if rows else 0


def _skip_to_first_point(stream: IO[bytes]) -> tuple[tuple[int, int, int], str | None, bool]:
    """Position the stream at the first point.

    Returns:
        Its columns, their delimiter, and whether a title names them.
    """
    if stream.read(len(codecs.BOM_UTF8)) != codecs.BOM_UTF8:
        stream.seek(0)
    titles: deque[str] = deque(maxlen=_LEADING_LINES)
    last_words = b""
    for _ in range(_LEADING_LINES):
        start, line = stream.tell(), stream.readline(10_000)
        while line and not _without_comment(line):
            if line.strip():
                titles.appendleft(_text(line))
            start, line = stream.tell(), stream.readline(10_000)
        if (found := _point(titles, _text(_without_comment(line)))) is not None:
            stream.seek(start)
            named = any(named_columns(title, _text(_without_comment(line))) for title in titles)
            return *found, named
        if line:
            titles.appendleft(_text(line))
            last_words = line
    raise InputError(f"has no line of three numbers at its beginning, but {last_words[:40]!r}")


def _point(titles: Iterable[str], row: str) -> tuple[tuple[int, int, int], str | None] | None:
    """Columns of x, y, z in a row and its delimiter; None where the row is no point.

    Args:
        titles: The lines above it, the nearest first.
        row: The line.
    """
    named = next(filter(None, (named_columns(title, row) for title in titles)), None)
    columns, delimiter = named or (FIRST_THREE, delimiter_of(row))
    words = split(row, delimiter)
    if len(words) <= max(columns) or not all(is_number(words[column]) for column in columns):
        return None
    if named is None:
        check_first_three(titles, row)
    return columns, delimiter


def _text(line: bytes) -> str:
    return line.decode("utf-8", errors="replace")


def _without_comment(line: bytes) -> bytes:
    return line.partition(b"#")[0].partition(b"//")[0].strip()


def read_pts(path: Path) -> FileShape:
    """Read x, y, z of all scans; intensity and colours are ignored.

    A file without counts is read as XYZ.

    Raises:
        InputError: No table of numbers, or fewer points than announced.
    """
    counts: list[int] = []
    with path.open("rb") as stream:
        first = next((line for line in stream if line.strip()), b"")
        if not first.strip().isdigit():
            return read_xyz(path)
        stream.seek(0)
        points = read_table(_rows(stream, counts), columns=3)
    if len(points) != sum(counts):
        raise InputError(
            f"ends too early: {sum(counts)} points announced, {len(points)} found"
            if len(points) < sum(counts)
            else f"holds {len(points)} points, and {sum(counts)} are announced"
        )
    return FileShape(points)


def _rows(stream: IO[bytes], counts: list[int]) -> Iterator[bytes]:
    """Lines of points; the counts between them are collected."""
    for line in stream:
        if line.strip().isdigit():
            counts.append(int(line))
        else:
            yield line
