"""The records of an MCAP file in their order; damaged ones are skipped and counted."""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Iterator
from typing import TYPE_CHECKING, BinaryIO

from circumspect.errors import InputError
from circumspect.recording.bounded_unpacking import LARGEST
from circumspect.recording.mcap_chunk import (
    CHANNEL,
    LONGEST_DESCRIPTION,
    MESSAGE,
    SCHEMA,
    record_in,
    records_of,
)

if TYPE_CHECKING:
    from mcap.records import Channel, Message, Metadata, Schema

MAGIC = b"\x89MCAP0\r\n"
_FOOTER, _CHUNK, _INDEX, _ATTACHMENT, _METADATA, _DATA_END = 0x02, 0x06, 0x07, 0x09, 0x0C, 0x0F
_EXACT = {_FOOTER: 20, 0x0E: 17, _DATA_END: 4}
"""Lengths of records that have always the same."""
_LEAST = {0x01: 8, SCHEMA: 14, CHANNEL: 16, MESSAGE: 22, _CHUNK: 40, _INDEX: 6, 0x08: 64,
          _ATTACHMENT: 36, 0x0A: 48, 0x0B: 46, _METADATA: 8, 0x0D: 20}  # fmt: skip
"""Lengths that records have at least."""
_PRIVATE = 0x80
"""Records of other programs have this opcode or a higher one."""
_HEAD = struct.Struct("<BQ")
_BEGIN = re.compile(rb"(?=[\x01-\x0f][\s\S]{3}[\x00-\x10]\0{4})")
"""What a record may begin with: an opcode, and a length of at most `LARGEST`."""
_PIECE = 1 << 20
_IN_A_ROW = 3
"""Bytes that continue as so many records in a row are records."""


class McapRecords:
    """Reads a file from its beginning to its end, once.

    The file of a process that was killed breaks off. A disk or a network may have changed some
    bits. A record that is damaged is skipped, the reader looks for the next sound one, and what
    lies between is counted.

    Attributes:
        damaged_parts: How many stretches of the file are damaged so far.
        damaged_bytes: Their length.
        cut_bytes: Length of what follows the last whole record, where the file breaks off; None
            where it ends as it should.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = os.fstat(stream.fileno()).st_size
        self.damaged_parts = self.damaged_bytes = 0
        self.cut_bytes: int | None = None
        self._damaged_to = 0

    def __iter__(self) -> Iterator[Channel | Message | Metadata | Schema]:
        at = len(MAGIC)
        while at < self._size:
            head = self._head(at)
            if head is None or not self._is_followed(head[1]):
                found = self._next_sound(at + 1)
                if found is None and head is None:
                    break
                if found is not None and (head is None or found < head[1]):
                    self._count_damage(at, found)
                    at = found
                    continue
            assert head is not None
            opcode, end = head
            if opcode in (_FOOTER, _DATA_END):
                return
            try:
                yield from self._record(opcode, at + _HEAD.size, end)
            except Exception:  # whatever a parser makes of broken bytes
                self._count_damage(at, end)
            at = end
        self.cut_bytes = self._size - at

    def _count_damage(self, begin: int, end: int) -> None:
        self.damaged_parts += begin != self._damaged_to
        self.damaged_bytes += end - begin
        self._damaged_to = end

    def _head(self, at: int) -> tuple[int, int] | None:
        """Opcode and end of the record at a place; None where no record can be."""
        self._stream.seek(at)
        head = self._stream.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        opcode, length = _HEAD.unpack(head)
        end = at + _HEAD.size + length
        # Attachments are never loaded.
        fits = end <= self._size and (length <= LARGEST or opcode == _ATTACHMENT)
        if opcode in _EXACT:
            possible = length == _EXACT[opcode]
        else:
            possible = opcode >= _PRIVATE or length >= _LEAST.get(opcode, length + 1)
        return (opcode, end) if fits and possible else None

    def _is_followed(self, end: int) -> bool:
        return end == self._size or self._head(end) is not None

    def _next_sound(self, begin: int) -> int | None:
        """Where the next record begins that sound ones follow, from a place on."""
        overlap = _HEAD.size - 1
        while begin < self._size:
            self._stream.seek(begin)
            piece = self._stream.read(_PIECE + overlap)
            for match in _BEGIN.finditer(piece):
                if match.start() < _PIECE and self._is_sound(begin + match.start()):
                    return begin + match.start()
            begin += _PIECE
        return None

    def _is_sound(self, at: int) -> bool:
        for _ in range(_IN_A_ROW):
            head = self._head(at)
            if head is None:
                return False
            opcode, at = head
            if opcode in (_FOOTER, _DATA_END) or at == self._size:
                return True
        return True

    def _record(
        self, opcode: int, begin: int, end: int
    ) -> Iterator[Channel | Message | Metadata | Schema]:
        self._stream.seek(begin)
        if opcode == _INDEX:
            (length,) = struct.unpack("<xxI", self._stream.read(6))
            if length != end - begin - 6:
                raise InputError("an index of another length")
        elif opcode == _CHUNK:
            yield from records_of(self._stream.read(end - begin))
        elif opcode == _METADATA and end - begin <= LONGEST_DESCRIPTION:
            yield _metadata(self._stream.read(end - begin))
        elif opcode in (MESSAGE, CHANNEL, SCHEMA):
            yield record_in(opcode, memoryview(self._stream.read(end - begin)))


def _metadata(body: bytes) -> Metadata:
    from io import BytesIO

    from mcap.data_stream import ReadDataStream
    from mcap.records import Metadata

    return Metadata.read(ReadDataStream(BytesIO(body)))
