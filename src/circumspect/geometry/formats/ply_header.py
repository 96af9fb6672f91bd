"""The header of a PLY file: its elements and their properties."""

from __future__ import annotations

from dataclasses import dataclass, replace

from circumspect.errors import InputError
from circumspect.geometry.formats.column_titles import unique_names

# Name in the header (old and new style) -> NumPy's name of the type.
_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
MAX_HEADER_BYTES = 1 << 18
MAX_ENTRIES = 500
"""Largest number of elements and properties; files of measurements have a dozen."""
_BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class PlyProperty:
    """A number, or a list of numbers after its length.

    Attributes:
        name: As in the header.
        type: NumPy type of the number, as "f4".
        count_type: NumPy type of the length; None where this is no list.
    """

    name: str
    type: str
    count_type: str | None = None


@dataclass(frozen=True)
class PlyElement:
    """A table of `count` rows."""

    name: str
    count: int
    properties: tuple[PlyProperty, ...]

    @property
    def has_lists(self) -> bool:
        """Whether rows may differ in length."""
        return any(item.count_type for item in self.properties)


@dataclass(frozen=True)
class PlyHeader:
    """The header.

    Attributes:
        byte_order: "<" or ">"; "" for ASCII.
        elements: In the order of the file.
        size: Bytes up to the first row.
    """

    byte_order: str
    elements: tuple[PlyElement, ...]
    size: int


def parse_ply_header(data: bytes) -> PlyHeader:
    """Read the header at the beginning of `data`.

    Raises:
        InputError: Not a PLY file, or a header that is broken.
    """
    if data[:3] != b"ply":
        raise InputError("is not a PLY file: it does not begin with ply; check the format")
    newline = next((mark for mark in (b"\r\n", b"\n", b"\r") if data[3:].startswith(mark)), b"\n")
    end = data.find(newline + b"end_header")
    if end < 0:
        raise InputError("is a broken PLY file: its header has no end; it may be truncated")
    if end > MAX_HEADER_BYTES:
        raise InputError(f"is a PLY file with a header of {end} bytes; no such file is read")
    body = data.find(newline, end + len(newline))
    lines = [line.split() for line in data[:end].decode("latin-1").splitlines()[1:]]
    try:
        return PlyHeader(
            _byte_order(lines), _elements(lines), len(data) if body < 0 else body + len(newline)
        )
    except (ValueError, IndexError, KeyError) as error:
        raise InputError(f"is a PLY file with a broken header ({error})") from error


def _byte_order(lines: list[list[str]]) -> str:
    formats = [words[1] for words in lines if words[:1] == ["format"]]
    return _BYTE_ORDERS[formats[0]]


def _elements(lines: list[list[str]]) -> tuple[PlyElement, ...]:
    if sum(words[:1] in (["element"], ["property"]) for words in lines) > MAX_ENTRIES:
        raise ValueError(f"more than {MAX_ENTRIES} elements and properties")
    elements: list[PlyElement] = []
    properties: list[PlyProperty] = []
    for words in lines:
        keyword = words[0] if words else ""
        if keyword == "element":
            properties = []
            elements.append(PlyElement(words[1], _whole(words[2]), ()))
        elif keyword == "property":
            properties.append(_property(words))
            last = elements[-1]
            elements[-1] = PlyElement(last.name, last.count, tuple(properties))
    return tuple(_with_unique_names(element) for element in elements)


def _with_unique_names(element: PlyElement) -> PlyElement:
    names = unique_names([item.name for item in element.properties])
    properties = zip(element.properties, names, strict=True)
    return replace(element, properties=tuple(replace(item, name=name) for item, name in properties))


def _property(words: list[str]) -> PlyProperty:
    if words[1] != "list":
        return PlyProperty(words[2], _TYPES[words[1]])
    count_type = _TYPES[words[2]]
    if count_type.startswith("f"):
        raise ValueError("the length of a list is no whole number")
    return PlyProperty(words[4], _TYPES[words[3]], count_type)


def _whole(word: str) -> int:
    count = int(word)
    if count < 0:
        raise ValueError("negative count")
    return count
