"""The rows of a PLY file after its header, element by element, in text or in binary."""

from __future__ import annotations

import io
import struct
from abc import ABC, abstractmethod
from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.number_table import read_table
from circumspect.geometry.formats.ply_header import PlyElement, PlyHeader

Columns = dict[str, NDArray[Any]]
Polygons = NDArray[Any] | list[Sequence[float]]

_STRUCT_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}  # fmt: skip  # noqa: E501


class PlyRows(ABC):
    """Reads the elements in sequence. Counts in the header never determine allocations."""

    @abstractmethod
    def scalars(self, element: PlyElement) -> Columns:
        """The next element, without lists, as columns by name."""

    @abstractmethod
    def mixed(
        self, element: PlyElement, numbers: tuple[str, ...], lists: tuple[str, ...]
    ) -> tuple[Columns, Polygons]:
        """The next element, with lists.

        Args:
            element: Its header.
            numbers: Names of the properties that are single numbers to return, where they exist.
            lists: Names; the first list property with one of them is returned, row by row.
        """


def ply_rows(data: bytes, header: PlyHeader) -> PlyRows:
    """The reader of the rows after this header."""
    return BinaryRows(data, header) if header.byte_order else AsciiRows(data, header)


class BinaryRows(PlyRows):
    """Binary rows: one structured array if all rows are alike, else row by row."""

    def __init__(self, data: bytes, header: PlyHeader) -> None:
        self._data = data
        self._order = header.byte_order
        self._offset = header.size

    def scalars(self, element: PlyElement) -> Columns:
        """See `PlyRows`."""
        fields = [(item.name, self._order + item.type) for item in element.properties]
        return self._table(element, np.dtype(fields))

    def mixed(
        self, element: PlyElement, numbers: tuple[str, ...], lists: tuple[str, ...]
    ) -> tuple[Columns, Polygons]:
        """See `PlyRows`."""
        chosen = chosen_list(element, lists)
        if element.count and (alike := self._alike(element)) is not None:
            columns = {name: alike[name] for name in numbers if _is_number(element, name)}
            return columns, [] if chosen is None else alike[chosen]
        return self._one_by_one(element, numbers, chosen)

    def _table(self, element: PlyElement, row: np.dtype) -> Columns:
        size = element.count * row.itemsize
        if self._offset + size > len(self._data):
            raise _too_short(element, (len(self._data) - self._offset) // row.itemsize)
        if row.itemsize == 0:
            return {}
        table = np.frombuffer(self._data, row, element.count, self._offset)
        self._offset += size
        return {name: table[name] for name in row.names or ()}

    def _alike(self, element: PlyElement) -> Columns | None:
        """The element as a table, if all rows have lists as long as those of the first."""
        start = self._offset
        fields: list[tuple[Any, ...]] = []
        lengths: dict[str, int] = {}
        for item in element.properties:
            if item.count_type is None:
                fields.append((item.name, self._order + item.type))
                continue
            count_name = f"length of {item.name}"
            fields.append((count_name, self._order + item.count_type))
            count_at = start + np.dtype(fields).itemsize - int(item.count_type[1])
            length = self._length(count_at, item.count_type)
            if length is None or length * int(item.type[1]) > len(self._data):
                return None
            lengths[count_name] = length
            fields.append((item.name, self._order + item.type, (length,)))
        row = np.dtype(fields)
        if start + element.count * row.itemsize > len(self._data):
            return None
        columns = self._table(element, row)
        if all((columns[name] == length).all() for name, length in lengths.items()):
            return columns
        self._offset = start
        return None

    def _length(self, offset: int, count_type: str) -> int | None:
        try:
            (length,) = struct.unpack_from(
                self._order + _STRUCT_CODES[count_type], self._data, offset
            )
        except struct.error:
            return None
        return length if length >= 0 else None

    def _one_by_one(
        self, element: PlyElement, numbers: tuple[str, ...], chosen: str | None
    ) -> tuple[Columns, Polygons]:
        """Rows of different lengths; only the requested properties are kept."""
        columns = {name: array("d") for name in numbers if _is_number(element, name)}
        steps = [
            (
                struct.Struct(self._order + _STRUCT_CODES[item.count_type or item.type]),
                _STRUCT_CODES[item.type] if item.count_type else "",
                int(item.type[1]),
                item.name == chosen,
                None if item.count_type else columns.get(item.name),
            )
            for item in element.properties
        ]
        data, offset, rows = self._data, self._offset, []
        for index in range(element.count):
            try:
                for head, code, size, wanted, column in steps:
                    (value,) = head.unpack_from(data, offset)
                    offset += head.size
                    if not code:
                        if column is not None:
                            column.append(value)
                        continue
                    if value < 0 or offset + value * size > len(data):
                        raise _too_short(element, index)
                    if wanted:
                        rows.append(struct.unpack_from(f"{self._order}{value}{code}", data, offset))
                    offset += value * size
            except struct.error:
                raise _too_short(element, index) from None
        self._offset = offset
        return {name: np.array(column) for name, column in columns.items()}, rows


class AsciiRows(PlyRows):
    """Text rows, one per line."""

    def __init__(self, data: bytes, header: PlyHeader) -> None:
        self._stream = io.BytesIO(data)
        self._stream.seek(header.size)

    def scalars(self, element: PlyElement) -> Columns:
        """See `PlyRows`."""
        if not element.properties:
            return {}
        table = read_table(self._stream, rows=element.count, columns=len(element.properties))
        return {item.name: table[:, index] for index, item in enumerate(element.properties)}

    def mixed(
        self, element: PlyElement, numbers: tuple[str, ...], lists: tuple[str, ...]
    ) -> tuple[Columns, Polygons]:
        """See `PlyRows`."""
        columns = {name: array("d") for name in numbers if _is_number(element, name)}
        chosen, rows = chosen_list(element, lists), []
        for index in range(element.count):
            line = self._stream.readline()
            while line.isspace():
                line = self._stream.readline()
            if not line:
                raise _too_short(element, index)
            try:
                found = _parts_of_line([float(word) for word in line.split()], element)
            except (ValueError, IndexError, OverflowError):
                raise InputError(f"has a broken {element.name}: {line[:60]!r}") from None
            for name, column in columns.items():
                column.append(found[name][0])
            if chosen is not None:
                rows.append(found[chosen])
        return {name: np.array(column) for name, column in columns.items()}, rows


def _parts_of_line(numbers: list[float], element: PlyElement) -> dict[str, list[float]]:
    """Property names to the values in a row; a number is a list of one."""
    parts, position = {}, 0
    for item in element.properties:
        length = 1
        if item.count_type is not None:
            length = int(numbers[position])
            position += 1
        values = numbers[position : position + length]
        if length < 0 or len(values) < length:
            raise ValueError
        parts[item.name] = values
        position += length
    return parts


def chosen_list(element: PlyElement, names: tuple[str, ...]) -> str | None:
    """The first list property of an element with one of these names."""
    lists = (item.name for item in element.properties if item.count_type and item.name in names)
    return next(lists, None)


def _is_number(element: PlyElement, name: str) -> bool:
    return any(item.name == name and item.count_type is None for item in element.properties)


def _too_short(element: PlyElement, found: int) -> InputError:
    return InputError(
        f"ends too early: {element.count} rows of {element.name!r} announced, {found} found; "
        "it may be truncated"
    )
