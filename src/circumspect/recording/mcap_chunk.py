"""What a chunk of an MCAP file holds."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import TYPE_CHECKING

from circumspect.errors import InputError
from circumspect.recording.bounded_unpacking import unpacked

if TYPE_CHECKING:
    from mcap.records import Channel, Message, Schema

SCHEMA, CHANNEL, MESSAGE = 0x03, 0x04, 0x05
"""Opcodes of the records in chunks."""
LONGEST_DESCRIPTION = 1 << 20
"""Of a channel, a message type, or a note [bytes]; a file has up to 65,536 of each."""
LONGEST_NAME = 1024
"""Of a topic or a message type [characters]."""
FEW = 1000
"""So many records are read of any chunk, and of a larger one as many more as its packed bytes:
messages have times that differ, and do not pack into less."""
_CHUNK = struct.Struct("<QQQII")
_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")


def records_of(body: bytes) -> Iterator[Channel | Message | Schema]:
    """Unpack a chunk and read its records one after the other, as they are asked for.

    Args:
        body: The chunk's record, without opcode and length.

    Raises:
        InputError: It unpacks to more than it claims or to something else, holds more records
            than any recording, or names that are too long. Broken records may raise other
            exceptions as well.
    """
    _, _, size, crc, length = _CHUNK.unpack_from(body)
    begin = _CHUNK.size + length
    packing = str(body[_CHUNK.size : begin], "utf-8")
    packed = memoryview(body)[begin + 8 :]
    if len(packed) != int.from_bytes(body[begin : begin + 8], "little"):
        raise InputError("a chunk has another length than it claims")
    plain = memoryview(unpacked(packed, packing, size))
    if crc not in (0, zlib.crc32(plain)):
        raise InputError("a chunk is not what was written")
    at, left = 0, FEW + len(packed)
    while at < len(plain):
        if left == 0:
            raise InputError("a chunk holds more records than any recording")
        left -= 1
        opcode, length = _HEAD.unpack_from(plain, at)
        begin, at = at + _HEAD.size, at + _HEAD.size + length
        if at > len(plain):
            raise InputError("a chunk ends within a record")
        if opcode in (SCHEMA, CHANNEL, MESSAGE):
            yield record_in(opcode, plain[begin:at])


def record_in(opcode: int, body: memoryview) -> Channel | Message | Schema:
    """Read a message, a channel, or a message type.

    Raises:
        InputError: A name or a description is too long. Broken records may raise other exceptions
            as well.
    """
    from mcap.data_stream import ReadDataStream
    from mcap.records import Channel, Message, Schema

    if opcode == MESSAGE:
        channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(body)
        data = bytes(body[_MESSAGE.size :])
        return Message(channel, log_time, data, publish_time, sequence)
    if len(body) > LONGEST_DESCRIPTION:
        raise InputError(f"a topic or a type of more than {LONGEST_DESCRIPTION} bytes")
    stream = ReadDataStream(BytesIO(body))
    found = Schema.read(stream) if opcode == SCHEMA else Channel.read(stream)
    if max(map(len, _names(found))) > LONGEST_NAME:
        raise InputError(f"a name of more than {LONGEST_NAME} characters")
    return found


def _names(record: Channel | Schema) -> tuple[str, ...]:
    from mcap.records import Schema

    if isinstance(record, Schema):
        return record.name, record.encoding
    return record.topic, record.message_encoding
