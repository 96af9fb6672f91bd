"""XYZ, TXT, CSV: a point a line."""

from __future__ import annotations

import codecs
from pathlib import Path
from typing import IO

from circumspect.errors import InputError
from circumspect.geometry.file_shape import FileShape
from circumspect.geometry.number_table import read_table

# So many lines of titles or counts may stand before the first point.
_LEADING_LINES = 10


def read_xyz(path: Path) -> FileShape:
    """Read x, y, z from the first three columns; blanks, commas or semicolons between them.

    Titles before the first point, comments (# or //) and further columns are passed over.

    Raises:
        InputError: No table of numbers.
    """
    with path.open("rb") as stream:
        delimiter = _skip_to_first_point(stream)
        lines = (told for line in stream if (told := _without_comment(line)))
        return FileShape(read_table(lines, columns=3, delimiter=delimiter))


def _skip_to_first_point(stream: IO[bytes]) -> str | None:
    """Leave the stream where the first line of three numbers begins; return the delimiter."""
    if stream.read(len(codecs.BOM_UTF8)) != codecs.BOM_UTF8:
        stream.seek(0)
    last_words = b""
    for _ in range(_LEADING_LINES):
        start, line = stream.tell(), stream.readline(10_000)
        while line and not _without_comment(line):
            start, line = stream.tell(), stream.readline(10_000)
        told = _without_comment(line)
        delimiter = next((mark for mark in (b",", b";") if mark in told), None)
        if _numbers(told.split(delimiter)[:3]) == 3:
            stream.seek(start)
            return delimiter.decode() if delimiter else None
        last_words = line or last_words
    raise InputError(f"has no line of three numbers at its beginning, but {last_words[:40]!r}")


def _without_comment(line: bytes) -> bytes:
    return line.partition(b"#")[0].partition(b"//")[0].strip()


def _numbers(words: list[bytes]) -> int:
    count = 0
    for word in words:
        try:
            float(word)
        except ValueError:
            continue
        count += 1
    return count
