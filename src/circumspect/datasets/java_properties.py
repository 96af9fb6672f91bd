"""Java's .properties files: lines of keys and values with escapes."""

from __future__ import annotations

import re
from collections.abc import Iterator

from circumspect.errors import InputError

BLANK = " \t\f"
_ENTRY = re.compile(r"((?:\\.|[^\\=: \t\f])*)[ \t\f]*[=:]?[ \t\f]*(.*)", re.DOTALL)
_ESCAPE = re.compile(r"\\(u.{0,4}|.)", re.DOTALL)
_CONTROLS = {"t": "\t", "n": "\n", "r": "\r", "f": "\f"}


def parse_properties(data: bytes) -> dict[str, str]:
    r"""Read keys and values; the last value of a repeated key counts.

    Args:
        data: The file, in ISO-8859-1; other characters are written as \uXXXX.

    Raises:
        InputError: An escape \u without four hexadecimal digits.
    """
    properties = {}
    for line in _logical_lines(data.decode("latin-1")):
        entry = _ENTRY.fullmatch(line)
        if entry is not None:
            properties[_unescaped(entry[1])] = _unescaped(entry[2])
    return properties


def _logical_lines(text: str) -> Iterator[str]:
    """Logical lines without comments and blank lines; a backslash at the end joins two lines."""
    begun = None
    for line in re.split(r"\r\n|\n|\r", text):
        stripped = line.lstrip(BLANK)
        if begun is None and (not stripped or stripped[0] in "#!"):
            continue
        whole = (begun or "") + stripped
        if (len(stripped) - len(stripped.rstrip("\\"))) % 2:
            begun = whole[:-1]
        else:
            begun = None
            yield whole
    if begun:
        yield begun


def _unescaped(text: str) -> str:
    if "\\" not in text:
        return text
    plain = _ESCAPE.sub(_character, text)
    # Characters beyond 16 bits are written as two escapes.
    return plain.encode("utf-16", "surrogatepass").decode("utf-16", "replace")


def _character(escape: re.Match[str]) -> str:
    sign = escape[1]
    if sign[0] != "u":
        return _CONTROLS.get(sign, sign)
    if not re.fullmatch(r"u[0-9a-fA-F]{4}", sign):
        raise InputError(
            f"has a broken escape: {escape[0]!r}; four hexadecimal digits belong there"
        )
    return chr(int(sign[1:], 16))
