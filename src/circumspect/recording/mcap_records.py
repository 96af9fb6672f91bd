"""Records of an MCAP file in order; damaged ones are skipped and counted."""

from __future__ import annotations

import os
import re
import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import TYPE_CHECKING, BinaryIO

from circumspect.errors import InputError
from circumspect.recording.bounded_decompression import MAX_UNPACKED_BYTES, decompressed

if TYPE_CHECKING:
    from mcap.records import Channel, Message, Metadata, Schema

SCHEMA, CHANNEL, MESSAGE = 0x03, 0x04, 0x05
"""Opcodes of records inside chunks."""
MAX_DESCRIPTION_BYTES = 1 << 20
"""Maximum size of a channel, message type or note [bytes]; a file has up to 65,536 of each."""
MAX_NAME_LENGTH = 1024
"""Maximum length of the name of a topic or message type [characters]."""
MIN_RECORD_LIMIT = 1000
"""Number of records that any chunk may contain, plus one for each compressed byte.

Messages have different times and cannot compress to less than that."""
_CHUNK_HEAD = struct.Struct("<QQQII")
_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")


MAGIC = b"\x89MCAP0\r\n"
_FOOTER, _CHUNK, _INDEX, _ATTACHMENT, _METADATA, _DATA_END = 0x02, 0x06, 0x07, 0x09, 0x0C, 0x0F
_FIXED_LENGTHS = {_FOOTER: 20, 0x0E: 17, _DATA_END: 4}
"""Lengths of records with a fixed length."""
_MIN_LENGTHS = {0x01: 8, SCHEMA: 14, CHANNEL: 16, MESSAGE: 22, _CHUNK: 40, _INDEX: 6, 0x08: 64,
          _ATTACHMENT: 36, 0x0A: 48, 0x0B: 46, _METADATA: 8, 0x0D: 20}  # fmt: skip
"""Minimum lengths of records."""
_PRIVATE = 0x80
"""First opcode of records of other programs."""
_RECORD_START = re.compile(rb"(?=[\x01-\x0f][\s\S]{3}[\x00-\x10]\0{4})")
"""Possible start of a record: an opcode and a length of at most `MAX_UNPACKED_BYTES`."""
_PIECE_BYTES = 1 << 20
_MIN_CONSECUTIVE = 3
"""Consecutive valid records that confirm the start of a record."""


class McapRecords:
    """Reads a file sequentially, once.

    The file of a killed process is truncated, and a disk or network may have changed bits. A
    damaged record is skipped up to the next valid one, and the bytes between are counted.

    Attributes:
        damaged_parts: Number of damaged parts so far.
        damaged_bytes: Total size of the damaged parts.
        truncated_bytes: Size of the data after the last complete record of a truncated file; None
            if the file is complete.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = os.fstat(stream.fileno()).st_size
        self.damaged_parts = self.damaged_bytes = 0
        self.truncated_bytes: int | None = None
        self._damaged_to = 0

    def __iter__(self) -> Iterator[Channel | Message | Metadata | Schema]:
        at = len(MAGIC)
        while at < self._size:
            head = self._head(at)
            if head is None or not self._has_valid_successor(head[1]):
                found = self._next_valid(at + 1)
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
            except Exception:  # any error of a parser on broken data
                self._count_damage(at, end)
            at = end
        self.truncated_bytes = self._size - at

    def _count_damage(self, begin: int, end: int) -> None:
        self.damaged_parts += begin != self._damaged_to
        self.damaged_bytes += end - begin
        self._damaged_to = end

    def _head(self, at: int) -> tuple[int, int] | None:
        """Opcode and end of the record at an offset; None if there cannot be a record."""
        self._stream.seek(at)
        head = self._stream.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        opcode, length = _HEAD.unpack(head)
        end = at + _HEAD.size + length
        # Attachments are never loaded.
        fits = end <= self._size and (length <= MAX_UNPACKED_BYTES or opcode == _ATTACHMENT)
        if opcode in _FIXED_LENGTHS:
            possible = length == _FIXED_LENGTHS[opcode]
        else:
            possible = opcode >= _PRIVATE or length >= _MIN_LENGTHS.get(opcode, length + 1)
        return (opcode, end) if fits and possible else None

    def _has_valid_successor(self, end: int) -> bool:
        return end == self._size or self._head(end) is not None

    def _next_valid(self, begin: int) -> int | None:
        """Offset of the next record that is followed by valid ones."""
        overlap = _HEAD.size - 1
        while begin < self._size:
            self._stream.seek(begin)
            piece = self._stream.read(_PIECE_BYTES + overlap)
            for match in _RECORD_START.finditer(piece):
                if match.start() < _PIECE_BYTES and self._is_valid(begin + match.start()):
                    return begin + match.start()
            begin += _PIECE_BYTES
        return None

    def _is_valid(self, at: int) -> bool:
        for _ in range(_MIN_CONSECUTIVE):
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
                raise InputError("an index with a wrong length")
        elif opcode == _CHUNK:
            yield from records_of(self._stream.read(end - begin))
        elif opcode == _METADATA and end - begin <= MAX_DESCRIPTION_BYTES:
            yield _metadata(self._stream.read(end - begin))
        elif opcode in (MESSAGE, CHANNEL, SCHEMA):
            yield record_in(opcode, memoryview(self._stream.read(end - begin)))


def _metadata(body: bytes) -> Metadata:
    from io import BytesIO

    from mcap.data_stream import ReadDataStream
    from mcap.records import Metadata

    return Metadata.read(ReadDataStream(BytesIO(body)))


def records_of(body: bytes) -> Iterator[Channel | Message | Schema]:
    """Decompress a chunk and read its records lazily.

    Args:
        body: The chunk record without opcode and length.

    Raises:
        InputError: The chunk decompresses to more than it claims or fails its checksum, or has too
            many records or too long names. Broken records may raise other exceptions as well.
    """
    _, _, size, crc, length = _CHUNK_HEAD.unpack_from(body)
    begin = _CHUNK_HEAD.size + length
    compression = str(body[_CHUNK_HEAD.size : begin], "utf-8")
    packed = memoryview(body)[begin + 8 :]
    if len(packed) != int.from_bytes(body[begin : begin + 8], "little"):
        raise InputError("a chunk has a wrong length")
    plain = memoryview(decompressed(packed, compression, size))
    if crc not in (0, zlib.crc32(plain)):
        raise InputError("a chunk fails its checksum")
    at, left = 0, MIN_RECORD_LIMIT + len(packed)
    while at < len(plain):
        if left == 0:
            raise InputError("a chunk contains too many records")
        left -= 1
        opcode, length = _HEAD.unpack_from(plain, at)
        begin, at = at + _HEAD.size, at + _HEAD.size + length
        if at > len(plain):
            raise InputError("a chunk ends within a record")
        if opcode in (SCHEMA, CHANNEL, MESSAGE):
            yield record_in(opcode, plain[begin:at])


def record_in(opcode: int, body: memoryview) -> Channel | Message | Schema:
    """Read a message, channel or message type.

    Raises:
        InputError: A name or description is too long. Broken records may raise other exceptions as
            well.
    """
    from mcap.data_stream import ReadDataStream
    from mcap.records import Channel, Message, Schema

    if opcode == MESSAGE:
        channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(body)
        data = bytes(body[_MESSAGE.size :])
        return Message(channel, log_time, data, publish_time, sequence)
    if len(body) > MAX_DESCRIPTION_BYTES:
        raise InputError(f"a topic or a type of more than {MAX_DESCRIPTION_BYTES} bytes")
    stream = ReadDataStream(BytesIO(body))
    found = Schema.read(stream) if opcode == SCHEMA else Channel.read(stream)
    if max(map(len, _names(found))) > MAX_NAME_LENGTH:
        raise InputError(f"a name of more than {MAX_NAME_LENGTH} characters")
    return found


def _names(record: Channel | Schema) -> tuple[str, ...]:
    from mcap.records import Schema

    if isinstance(record, Schema):
        return record.name, record.encoding
    return record.topic, record.message_encoding
