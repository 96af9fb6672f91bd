"""MCAP files, whole or broken off."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from circumspect.errors import InputError, MissingExtraError, reason_of
from circumspect.recording.bag import Bag, BagMessage, Topic
from circumspect.recording.bag_safety import require_possible_size
from circumspect.recording.bounded_unpacking import LARGEST
from circumspect.recording.mcap_messages import KNOWN, Decoder, decoder_of, kind_of
from circumspect.recording.mcap_records import MAGIC, McapRecords
from circumspect.recording.mcap_writer import NOTES
from circumspect.recording.ros_types import typestore

if TYPE_CHECKING:
    from mcap.records import Channel, Message, Metadata, Schema

MOST_NOTES = 1000
"""An index that points to more of them is not believed: all may be the same large one."""
LONGEST_NOTES = 4 << 20
"""What exceeds so many characters of notes is left out."""
LARGEST_INDEX = 16 << 20
"""In memory an index takes many times its size [bytes]; with a larger one the file is read."""
MOST_TOPICS = 10_000
_FOOTER_AND_MAGIC, _SUMMARY_START = 37, slice(9, 17)


class McapBag(Bag):
    """An MCAP file of ROS 2, ROS 1 or Foxglove, read from its beginning to its end.

    A file that breaks off, as that of a process that was killed, is read as far as it goes. What
    is damaged within costs its chunk.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Look the file over: by its index, or without one by reading it through.

        Raises:
            InputError: It can not be read, is no MCAP file, or holds nothing.
            MissingExtraError: mcap or rosbags is not installed.
        """
        try:
            import mcap.reader  # noqa: F401
        except ImportError as error:
            raise MissingExtraError("mcap", "bags") from error
        self.path = Path(path)
        self.kind, self.fault, self.undecoded = "MCAP", None, Counter()
        self.damage = None
        self.topics: dict[str, Topic] = {}
        self.notes: dict[str, str] = {}
        typestore()
        try:
            if self.path.exists() and not self.path.is_file():
                raise InputError(f"{path}: is not a regular file")
            with self.path.open("rb") as stream:
                if stream.read(len(MAGIC)) != MAGIC:
                    raise InputError(f"{path}: is no MCAP file, or holds nothing")
        except OSError as error:
            raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
        self._described: dict[int, tuple[str, str, str]] = {}
        if not self._by_index():
            self._described.clear()
            self._by_reading()
        if not self.topics:
            raise InputError(f"{path}: holds no messages")

    def _by_index(self) -> bool:
        """Take the topics from the index at the end; False where there is none to rely on."""
        from mcap.reader import SeekingReader

        try:
            with self.path.open("rb") as stream:
                if _index_size(stream) > LARGEST_INDEX:
                    return False
                stream.seek(0)
                reader = SeekingReader(stream, record_size_limit=LARGEST)
                summary = reader.get_summary()
                if summary is None or summary.statistics is None or not summary.channels:
                    return False
                if len(summary.metadata_indexes) > MOST_NOTES:
                    return False
                statistics = summary.statistics
                counts = statistics.channel_message_counts
                if statistics.message_count and not counts:
                    return False
                first, last = statistics.message_start_time, statistics.message_end_time
                for number, channel in summary.channels.items():
                    # Where the chunk that describes a topic is damaged, the index still does.
                    schema = summary.schemas[channel.schema_id].name
                    self._described[number] = channel.topic, schema, channel.message_encoding
                    if count := counts.get(number, 0):
                        self._count(channel.topic, kind_of(schema), count, first, last)
                for record in reader.iter_metadata():
                    self._note(record)
        except Exception:  # whatever a parser makes of a broken index
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
        if topic not in self.topics and len(self.topics) >= MOST_TOPICS:
            raise InputError(f"{self.path}: holds more than {MOST_TOPICS} topics")
        known = self.topics.get(topic, Topic(topic, kind, 0))
        # Time may well be 0, in simulation.
        earliest = first if known.first is None else min(known.first, first)
        latest = last if known.last is None else max(known.last, last)
        self.topics[topic] = replace(known, count=known.count + count, first=earliest, last=latest)

    def _note(self, record: Any) -> None:
        if record.name == NOTES:
            noted = {**self.notes, **record.metadata}
            if sum(len(key) + len(value) for key, value in noted.items()) <= LONGEST_NOTES:
                self.notes = noted

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """See `Bag.messages`."""
        from mcap.records import Channel, Message, Schema

        self.undecoded = Counter()
        kinds: dict[int, str] = {}
        # What the file itself says on the way replaces what its index says.
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
                        told = decode(record.data)
                    except Exception:  # whatever a parser makes of broken bytes
                        self.undecoded[topic, kind] += 1
                        continue
                    yield BagMessage(topic, record.log_time, told)
                case _:
                    pass

    def _decoder(self, topic: str, schema: str, encoding: str) -> Decoder:
        decode = decoder_of(schema, encoding)
        if decode is None:
            raise InputError(
                f"{self.path}: {topic} holds {schema or 'messages without a type'} as "
                f"{encoding or 'nothing'}; known are {KNOWN}"
            )
        return decode

    def _records(self) -> Iterator[Channel | Message | Metadata | Schema]:
        """All records in order, up to the end or to where the file breaks off."""
        self.fault, self.damage = None, None
        with self.path.open("rb") as stream:
            size = os.fstat(stream.fileno()).st_size
            records = McapRecords(stream)
            yield from records
            if (left := records.cut_bytes) is not None:
                where = f": of {size} bytes the last {left} are no record"
                self.fault = f"broken off{where if left else ' after a whole record'}"
            if parts := records.damaged_parts:
                self.damage = (
                    f"{parts} damaged part{'s' * (parts > 1)}, {records.damaged_bytes} of "
                    f"{size} bytes"
                )


def _index_size(stream: BinaryIO) -> int:
    """From the beginning of the index to the end of the file [bytes]."""
    end = stream.seek(0, os.SEEK_END)
    stream.seek(max(end - _FOOTER_AND_MAGIC, 0))
    footer = stream.read(_FOOTER_AND_MAGIC)
    return end - int.from_bytes(footer[_SUMMARY_START], "little")
