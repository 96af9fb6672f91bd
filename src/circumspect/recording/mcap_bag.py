"""MCAP files, whole or broken off."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect.errors import InputError, MissingExtraError, reason_of
from circumspect.recording.bag import Bag, BagMessage, Topic
from circumspect.recording.bounded_unpacking import LARGEST
from circumspect.recording.mcap_chunk import records_of
from circumspect.recording.mcap_writer import NOTES
from circumspect.recording.ros_types import typestore

if TYPE_CHECKING:
    from mcap.records import McapRecord

MOST_NOTES = 1000
"""An index that points to more of them is not believed: all may be the same large one."""
MAGIC = b"\x89MCAP0\r\n"


class McapBag(Bag):
    """An MCAP file as ROS 2 or `McapWriter` writes it, read from its beginning to its end.

    A file that breaks off, as that of a process that was killed, is read as far as it goes.
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
        self.topics: dict[str, Topic] = {}
        self.notes: dict[str, str] = {}
        self._types = typestore()
        try:
            if self.path.exists() and not self.path.is_file():
                raise InputError(f"{path}: is not a regular file")
            with self.path.open("rb") as stream:
                if stream.read(len(MAGIC)) != MAGIC:
                    raise InputError(f"{path}: is no MCAP file, or holds nothing")
        except OSError as error:
            raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
        if not self._by_index():
            self._by_reading()
        if not self.topics:
            raise InputError(f"{path}: holds no messages")

    def _by_index(self) -> bool:
        """Take the topics from the index at the end; False where there is none to rely on."""
        from mcap.reader import SeekingReader

        try:
            with self.path.open("rb") as stream:
                reader = SeekingReader(stream, record_size_limit=LARGEST)
                summary = reader.get_summary()
                if summary is None or summary.statistics is None or not summary.channels:
                    return False
                if len(summary.metadata_indexes) > MOST_NOTES:
                    return False
                told = summary.statistics
                counts = told.channel_message_counts
                if told.message_count and not counts:
                    return False
                for number, channel in summary.channels.items():
                    if count := counts.get(number, 0):
                        kind = summary.schemas[channel.schema_id].name
                        first, last = told.message_start_time, told.message_end_time
                        self._count(channel.topic, kind, count, first, last)
                for record in reader.iter_metadata():
                    self._note(record)
        except Exception:  # whatever a parser makes of a broken index
            self.topics.clear()
            return False
        return True

    def _by_reading(self) -> None:
        from mcap.records import Channel, Message, Metadata, Schema

        schemas: dict[int, str] = {}
        channels: dict[int, Channel] = {}
        for record in self._records():
            match record:
                case Schema():
                    schemas[record.id] = record.name
                case Channel():
                    channels[record.id] = record
                case Metadata():
                    self._note(record)
                case Message() if record.channel_id in channels:
                    channel, time = channels[record.channel_id], record.log_time
                    kind = schemas.get(channel.schema_id, "")
                    self._count(channel.topic, kind, 1, time, time)
                case _:
                    pass

    def _count(self, topic: str, kind: str, count: int, first: int, last: int) -> None:
        known = self.topics.get(topic, Topic(topic, kind, 0))
        # Time may well be 0, in simulation.
        earliest = first if known.first is None else min(known.first, first)
        latest = last if known.last is None else max(known.last, last)
        self.topics[topic] = replace(known, count=known.count + count, first=earliest, last=latest)

    def _note(self, record: Any) -> None:
        if record.name == NOTES:
            self.notes |= record.metadata

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """See `Bag.messages`."""
        from mcap.records import Channel, Message, Schema

        self.undecoded = Counter()
        kinds: dict[int, str] = {}
        wanted: dict[int, tuple[str, str]] = {}
        for record in self._records():
            match record:
                case Schema():
                    kinds[record.id] = record.name
                case Channel() if record.topic in topics:
                    wanted[record.id] = record.topic, self._kind(record, kinds)
                case Message() if record.channel_id in wanted:
                    topic, kind = wanted[record.channel_id]
                    try:
                        told = self._types.deserialize_cdr(record.data, kind)
                    except Exception:  # whatever a parser makes of broken bytes
                        self.undecoded[topic, kind] += 1
                        continue
                    yield BagMessage(topic, record.log_time, told)
                case _:
                    pass

    def _kind(self, channel: Any, kinds: dict[int, str]) -> str:
        kind = kinds.get(channel.schema_id, "")
        if channel.message_encoding != "cdr" or kind not in self._types.fielddefs:
            raise InputError(
                f"{self.path}: {channel.topic} holds {kind or 'messages without a type'} as "
                f"{channel.message_encoding or 'nothing'}; known are messages of ROS 2 as cdr"
            )
        return kind

    def _records(self) -> Iterator[McapRecord]:
        """All records in order, up to the end or to where the file breaks off."""
        from mcap.records import Chunk, DataEnd
        from mcap.stream_reader import StreamReader

        self.fault, whole = None, 0
        with self.path.open("rb") as stream:
            size = os.fstat(stream.fileno()).st_size
            try:
                reader = StreamReader(stream, emit_chunks=True, record_size_limit=LARGEST)
                for record in reader.records:
                    if isinstance(record, DataEnd):
                        return
                    if isinstance(record, Chunk):
                        yield from records_of(record)
                    else:
                        yield record
                    whole = stream.tell()
            except Exception:  # whatever a parser makes of a broken file
                left = size - whole
                where = f": of {size} bytes the last {left} are no record"
                self.fault = f"broken off{where if left else ' after a whole record'}"
