"""XYZ, TXT, CSV: a point a line."""

from __future__ import annotations

import codecs
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import IO

from circumspect.errors import InputError
from circumspect.geometry.column_titles import (
    FIRST_THREE,
    check_first_three,
    delimiter_of,
    is_number,
    named_columns,
    split,
)
from circumspect.geometry.file_shape import FileShape
from circumspect.geometry.number_table import read_table

# So many lines of titles or counts may stand before the first point.
_LEADING_LINES = 10


def read_xyz(path: Path) -> FileShape:
    """Read x, y, z; blanks, commas or semicolons between them.

    They are in the columns that a title names x, y and z, otherwise in the first three. Words
    before the first point, comments (# or //) and further columns are passed over.

    Raises:
        InputError: No table of numbers, or its titles name columns that are no coordinates.
    """
    with path.open("rb") as stream:
        columns, delimiter = _skip_to_first_point(stream)
        lines = (told for line in stream if (told := _without_comment(line)))
        return FileShape(
            read_table(
                lines, columns=columns, delimiter=delimiter, quote='"' if delimiter else None
            )
        )


def _skip_to_first_point(stream: IO[bytes]) -> tuple[tuple[int, int, int], str | None]:
    """Leave the stream where the first point begins; return its columns and their delimiter."""
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
            return found
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
