"""Rows of numbers in text, by NumPy's own parser."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable
from typing import IO

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.ignored_warnings import ignored_warnings

_DECIMAL_COMMA = re.compile(r"'[-+]?\d+,\d+([eE][-+]?\d+)?'")


def read_table(
    source: IO[bytes] | Iterable[bytes] | Iterable[str],
    rows: int | None = None,
    columns: int | tuple[int, ...] | None = None,
    delimiter: str | None = None,
    comments: str | None = None,
    quote: str | None = None,
) -> NDArray[np.float64]:
    """Read lines of numbers; empty lines do not count.

    Args:
        source: An open binary file (read from its position on) or lines.
        rows: Number of rows; None means all up to the end.
        columns: The first so many columns, or those of these numbers; None means all, with equal
            numbers in all rows.
        delimiter: Between numbers; None means white space.
        comments: Prefix of a comment.
        quote: Quotation mark around words that may hold the delimiter.

    Returns:
        (rows, columns) numbers, NaN and infinite ones included.

    Raises:
        InputError: Something is not a number, a row is too short, or rows are missing.
    """
    taken = range(columns) if isinstance(columns, int) else columns
    width = 0 if taken is None else len(taken)
    if rows == 0:
        return np.empty((0, width))
    if rows is not None and isinstance(source, io.BytesIO):
        # A number and its delimiter take two bytes; loadtxt would allocate all announced rows.
        left = source.getbuffer().nbytes - source.tell()
        if rows * 2 * (width or 1) - 1 > left:
            raise InputError(f"ends too early: {rows} rows announced, {left} bytes left")
    try:
        with ignored_warnings():  # Of empty lines; a table without rows is refused below.
            table = np.loadtxt(
                source,
                max_rows=rows,
                usecols=taken,
                delimiter=delimiter,
                comments=comments,
                quotechar=quote,
                ndmin=2,
                encoding="latin-1",
            )
    except ValueError as error:
        comma = _DECIMAL_COMMA.search(str(error)) is not None and delimiter is None
        remedy = "; write decimal points in place of commas" if comma else ""
        raise InputError(f"has a broken table of numbers: {str(error)[:200]}{remedy}") from error
    if len(table) == 0:
        raise InputError("holds no numbers")
    if rows is not None and len(table) < rows:
        raise InputError(f"ends too early: {rows} rows announced, {len(table)} found")
    return table
