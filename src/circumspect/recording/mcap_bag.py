"""MCAP files, complete or truncated."""

from __future__ import annotations

import os
import zlib
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from circumspect.errors import InputError, MissingExtraError, reason_of
from circumspect.recording.bag import Bag, BagMessage, Topic
from circumspect.recording.bag_safety import require_possible_size
from circumspect.recording.bounded_decompression import MAX_UNPACKED_BYTES
from circumspect.recording.mcap_messages import SUPPORTED_ENCODINGS, Decoder, decoder_of, kind_of
from circumspect.recording.mcap_records import MAGIC, McapRecords
from circumspect.recording.mcap_writer import NOTES
from circumspect.recording.ros_types import typestore

if TYPE_CHECKING:
    from mcap.records import Channel, Message, Metadata, Schema

MAX_NOTE_RECORDS = 1000
"""Maximum number of note records in an index; more may all point to the same large record."""
MAX_NOTES_LENGTH = 4 << 20
"""Maximum length of the notes [characters]; further ones are ignored."""
MAX_INDEX_BYTES = 16 << 20
"""Maximum size of the index [bytes]; with a larger one the whole file is read instead."""
MAX_TOPICS = 10_000
_FOOTER_AND_MAGIC, _CRC_AND_MAGIC = 37, 12
_SUMMARY_START, _SUMMARY_CRC = slice(9, 17), slice(25, 29)


class McapBag(Bag):
    """An MCAP file of ROS 2, ROS 1 or Foxglove, read sequentially.

    A truncated file, such as that of a killed process, is read up to the break. Damaged chunks
    within the file are skipped.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Scan the file, using its index if there is one.

        Raises:
            InputError: The file cannot be read, is not an MCAP file, or is empty.
            MissingExtraError: mcap or rosbags is not installed.
        """
        try:
            import mcap.reader  # noqa: F401
        except ImportError as error:
            raise MissingExtraError("mcap", "bags") from error
        self.path = Path(path)
        self.kind, self.error, self.undecoded = "MCAP", None, Counter()
        self.damage = None
        self.topics: dict[str, Topic] = {}
        self.notes: dict[str, str] = {}
        typestore()
        try:
            if self.path.exists() and not self.path.is_file():
                raise InputError(f"{path}: is not a regular file")
            with self.path.open("rb") as stream:
                if stream.read(len(MAGIC)) != MAGIC:
                    raise InputError(f"{path}: is not an MCAP file, or is empty")
        except OSError as error:
            raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
        self._described: dict[int, tuple[str, str, str]] = {}
        if not self._by_index():
            self._described.clear()
            self._by_reading()
        if not self.topics:
            raise InputError(f"{path}: contains no messages")

    def _by_index(self) -> bool:
        """Read the topics from the index at the end; False if there is no usable index."""
        from mcap.reader import SeekingReader

        try:
            with self.path.open("rb") as stream:
                if not _is_index_usable(stream):
                    return False
                stream.seek(0)
                reader = SeekingReader(stream, record_size_limit=MAX_UNPACKED_BYTES)
                summary = reader.get_summary()
                if summary is None or summary.statistics is None or not summary.channels:
                    return False
                if len(summary.metadata_indexes) > MAX_NOTE_RECORDS:
                    return False
                statistics = summary.statistics
                counts = statistics.channel_message_counts
                if statistics.message_count and not counts:
                    return False
                first, last = statistics.message_start_time, statistics.message_end_time
                for number, channel in summary.channels.items():
                    # The index still describes a topic whose chunk is damaged.
                    schema = summary.schemas[channel.schema_id].name
                    self._described[number] = channel.topic, schema, channel.message_encoding
                    if count := counts.get(number, 0):
                        self._count(channel.topic, kind_of(schema), count, first, last)
                for record in reader.iter_metadata():
                    self._note(record)
        except Exception:  # any error of a parser on a broken index
            self.topics.clear()
            return False
        return True

    def _by_reading(self) -> None:
        from mcap.records import Channel, Message, Metadata, Schema

        kinds: dict[int, str] = {}
        channels: dict[int, tuple[str, int]] = {}
        for record in self._records():
            match record:
                case Schema():
                    kinds[record.id] = kind_of(record.name)
                case Channel():
                    channels[record.id] = record.topic, record.schema_id
                case Metadata():
                    self._note(record)
                case Message() if record.channel_id in channels:
                    topic, schema = channels[record.channel_id]
                    time = record.log_time
                    self._count(topic, kinds.get(schema, ""), 1, time, time)
                case _:
                    pass

    def _count(self, topic: str, kind: str, count: int, first: int, last: int) -> None:
        if topic not in self.topics and len(self.topics) >= MAX_TOPICS:
            raise InputError(f"{self.path}: contains more than {MAX_TOPICS} topics")
        known = self.topics.get(topic, Topic(topic, kind, 0))
        # In simulation, time may be 0.
        earliest = first if known.first is None else min(known.first, first)
        latest = last if known.last is None else max(known.last, last)
        self.topics[topic] = replace(known, count=known.count + count, first=earliest, last=latest)

    def _note(self, record: Any) -> None:
        if record.name == NOTES:
            noted = {**self.notes, **record.metadata}
            if sum(len(key) + len(value) for key, value in noted.items()) <= MAX_NOTES_LENGTH:
                self.notes = noted

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """See `Bag.messages`."""
        from mcap.records import Channel, Message, Schema

        self.undecoded = Counter()
        kinds: dict[int, str] = {}
        # Records of the file replace those of its index.
        wanted = {
            number: (topic, kind_of(schema), self._decoder(topic, schema, encoding))
            for number, (topic, schema, encoding) in self._described.items()
            if topic in topics
        }
        for record in self._records():
            match record:
                case Schema():
                    kinds[record.id] = record.name
                case Channel() if record.topic in topics:
                    schema = kinds.get(record.schema_id)
                    if schema is None and record.id in wanted:
                        continue
                    schema = schema or ""
                    decode = self._decoder(record.topic, schema, record.message_encoding)
                    wanted[record.id] = record.topic, kind_of(schema), decode
                case Channel():
                    wanted.pop(record.id, None)
                case Message() if record.channel_id in wanted:
                    topic, kind, decode = wanted[record.channel_id]
                    try:
                        require_possible_size(kind, len(record.data))
                        msg = decode(record.data)
                    except Exception:  # any error of a parser on broken data
                        self.undecoded[topic, kind] += 1
                        continue
                    yield BagMessage(topic, record.log_time, msg)
                case _:
                    pass

    def _decoder(self, topic: str, schema: str, encoding: str) -> Decoder:
        decode = decoder_of(schema, encoding)
        if decode is None:
            raise InputError(
                f"{self.path}: {topic} holds {schema or 'messages without a type'} as "
                f"{encoding or 'nothing'}; supported: {SUPPORTED_ENCODINGS}"
            )
        return decode

    def _records(self) -> Iterator[Channel | Message | Metadata | Schema]:
        """All records in order, up to the end or the truncation."""
        self.error, self.damage = None, None
        with self.path.open("rb") as stream:
            size = os.fstat(stream.fileno()).st_size
            records = McapRecords(stream)
            yield from records
            if (left := records.truncated_bytes) is not None:
                where = f": the last {left} of {size} bytes are not a record"
                self.error = f"truncated{where if left else ' after a complete record'}"
            if parts := records.damaged_parts:
                self.damage = (
                    f"{parts} damaged part{'s' * (parts > 1)}, {records.damaged_bytes} of "
                    f"{size} bytes"
                )


def _is_index_usable(stream: BinaryIO) -> bool:
    """Whether the index at the end is small and its checksum is that of the footer.

    The checksum is of all from the start of the index to the checksum itself; 0 means none
    (MCAP specification, "Footer").
    """
    end = stream.seek(0, os.SEEK_END)
    stream.seek(max(end - _FOOTER_AND_MAGIC, 0))
    footer = stream.read(_FOOTER_AND_MAGIC)
    start = int.from_bytes(footer[_SUMMARY_START], "little")
    if end - start > MAX_INDEX_BYTES:
        return False
    checksum = int.from_bytes(footer[_SUMMARY_CRC], "little")
    stream.seek(start)
    content = stream.read(max(end - start - _CRC_AND_MAGIC, 0))
    return checksum in (0, zlib.crc32(content))
