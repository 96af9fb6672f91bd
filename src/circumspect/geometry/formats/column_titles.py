"""Column names of tables: which columns are x, y and z, and names that repeat."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection, Iterable, Sequence

from circumspect.errors import InputError

FIRST_THREE = (0, 1, 2)
_DELIMITERS = (",", ";", "\t")
_MARKS = re.compile(r"\s*(?:#|//)[#/\s]*")
# Units in brackets behind a name: x [m].
_UNIT = re.compile(r"\[[^]]*\]|\([^)]*\)")
# Longer titles are remarks about the file.
_WORDS_IN_NAME = 2
COORDINATES = ("x", "y", "z")


def split(line: str, delimiter: str | None) -> list[str]:
    """The words of a line; those in double quotes may hold the delimiter, None is white space."""
    if delimiter is None:
        return line.split()
    try:
        words = next(csv.reader([line.rstrip("\r\n")], delimiter=delimiter), [])
    except csv.Error:
        words = line.split(delimiter)
    while words and not words[-1].strip():
        words.pop()
    return words


def delimiter_of(line: str) -> str | None:
    """The delimiter between the numbers of a row; None is white space."""
    return next((mark for mark in _DELIMITERS[:2] if mark in line), None)


def named_columns(title: str, row: str) -> tuple[tuple[int, int, int], str | None] | None:
    """Columns of x, y and z in a row of numbers, by a title.

    Args:
        title: A line above it, with or without # or // in front.
        row: The first row below that may hold a point.

    Returns:
        The three columns and the row's delimiter (None is white space); None if the title does not
        name all three, or is no row of names.

    Raises:
        InputError: It names other columns than the row has.
    """
    if (found := _names(title, row)) is None:
        return None
    names, delimiter = found
    if not {"x", "y", "z"} <= set(names):
        return None
    columns = (names.index("x"), names.index("y"), names.index("z"))
    count = len(split(row, delimiter))
    if columns == FIRST_THREE or len(names) == count:
        return columns, delimiter
    if delimiter is None or delimiter not in title:
        return None  # A sentence with these letters in it.
    raise InputError(
        f"names {len(names)} columns ({_listed(names)}), but its first row has {count}; name each"
    )


def check_first_three(titles: Iterable[str], row: str) -> None:
    """Refuse titles that name other columns than coordinates; remarks about the file are allowed.

    Args:
        titles: The lines above the first row; none of them names x, y and z.
        row: That row, three numbers at its beginning.

    Raises:
        InputError: A title names the columns, and the first three are not plainly coordinates.
    """
    for title in titles:
        found = _names(title, row)
        if found is None or not _are_columns(title, *found, row):
            continue
        names = found[0]
        if _alike(names[:3]):
            continue
        raise InputError(
            f"names its columns {_listed(names)}; x, y and z are not all there: name the "
            "coordinates so, or put them first and delete that line"
        )


def _names(title: str, row: str) -> tuple[list[str], str | None] | None:
    """Words of a title in small letters and the row's delimiter; None where one is a number."""
    bare = _UNIT.sub("", _MARKS.sub("", title, count=1)).rstrip("\r\n")
    delimiter = delimiter_of(row)
    if delimiter is None and "\t" in bare and "\t" in row:
        delimiter = "\t"
    if delimiter is None or delimiter not in bare:
        # Blanks may stand between the names and commas between the numbers, or the reverse.
        words = re.split(r"[,;\s]+", bare.strip())
    else:
        words = split(bare, delimiter)
    names = [word.strip().strip("\"'").strip().lower() for word in words]
    return None if any(map(is_number, names)) else (names, delimiter)


def _are_columns(title: str, names: list[str], delimiter: str | None, row: str) -> bool:
    """Whether a title without x, y and z names columns, not the file."""
    count = len(split(row, delimiter))
    longest = 1 if _MARKS.match(title) else _WORDS_IN_NAME
    if len(names) != count or any(len(name.split()) > longest for name in names):
        return False
    some = len({"x", "y", "z"} & set(names))
    if delimiter is None or delimiter not in title:
        return some == 2  # So many words may be a sentence as well.
    # All there is of three columns are the coordinates, however they are called.
    return count > 3 or some > 0


def _alike(names: list[str]) -> bool:
    """Whether three names differ only in x, y and z, as px, py, pz do; normals do not count."""
    bare = {name.replace(axis, "", 1) for name, axis in zip(names, "xyz", strict=True)}
    return len(bare) == 1 and not bare & {*names, "n", "normal", "normal_", "normals_"}


def is_number(word: str) -> bool:
    """Whether a word is a number; NaN and infinity are."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def _listed(names: list[str]) -> str:
    shown = ", ".join(name or "''" for name in names[:6])
    return f"{shown}, …" if len(names) > 6 else shown


def unique_names(names: Sequence[str], needed: Collection[str] = COORDINATES) -> tuple[str, ...]:
    """The names, numbered where they repeat, as "intensity 2".

    Args:
        names: As in the header.
        needed: Names that must be unique.

    Raises:
        ValueError: One of the needed names stands twice.
    """
    uses: dict[str, int] = {}
    unique = []
    for name in names:
        uses[name] = uses.get(name, 0) + 1
        if uses[name] == 1:
            unique.append(name)
            continue
        if name in needed:
            raise ValueError(f"{name!r} stands twice")
        unique.append(f"{name} {uses[name]}")
    return tuple(unique)
