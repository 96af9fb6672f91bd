"""What a chunk of an MCAP file holds."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import TYPE_CHECKING

from circumspect.errors import InputError
from circumspect.recording.bounded_unpacking import unpacked

if TYPE_CHECKING:
    from mcap.records import Channel, Chunk, Message, Schema

FEW = 1000
"""So many records are read of any chunk, and of a larger one as many more as its packed bytes:
messages have times that differ, and do not pack into less."""


def records_of(chunk: Chunk) -> Iterator[Channel | Message | Schema]:
    """Unpack a chunk and read its records one after the other, as they are asked for.

    Raises:
        InputError: It unpacks to more than it claims or to something else, or holds more records
            than any recording. Broken records may raise other exceptions as well.
    """
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Channel, Message, Schema

    plain = unpacked(chunk.data, chunk.compression, chunk.uncompressed_size)
    if chunk.uncompressed_crc not in (0, zlib.crc32(plain)):
        raise InputError("a chunk is not what was written")
    stream, left = ReadDataStream(BytesIO(plain)), FEW + len(chunk.data)
    while stream.count < len(plain):
        if left == 0:
            raise InputError("a chunk holds more records than any recording")
        left -= 1
        opcode, length = stream.read1(), stream.read8()
        end = stream.count + length
        if opcode == Opcode.MESSAGE:
            yield Message.read(stream, length)
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(stream)
        elif opcode == Opcode.SCHEMA:
            yield Schema.read(stream)
        # Other kinds, and what later versions of the format may add to these.
        stream.read(max(end - stream.count, 0))
