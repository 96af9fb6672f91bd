"""Bags of ROS 1 and of ROS 2, by rosbags."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from circumspect.errors import InputError
from circumspect.recording.bag import Bag, BagMessage, Topic
from circumspect.recording.bag_safety import (
    require_bounded_messages,
    require_plain_bag,
    require_possible_size,
)
from circumspect.recording.bounded_unpacking import bound_rosbags
from circumspect.recording.readable_stretches import ReadableStretches
from circumspect.recording.ros_time import NANOSECONDS
from circumspect.recording.ros_types import typestore

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection


class _PlainSuffix(type(Path())):
    """A path by whose suffix rosbags knows the format, even if that is in capitals."""

    @property
    def suffix(self) -> str:
        return super().suffix.lower()


class RosBag(Bag):
    """A ROS 1 bag, a db3 file or a rosbag2 folder."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Open it and read its index.

        Raises:
            InputError: It can not be read.
            MissingExtraError: rosbags is not installed.
        """
        self.path, self.notes, self.fault, self.damage = Path(path), {}, None, None
        self.undecoded = Counter()
        self.kind = "ROS 1 bag" if self.path.suffix.lower() == ".bag" else "ROS 2 bag"
        if not self.path.exists():
            raise InputError(f"{path}: no such file or folder")
        require_plain_bag(self.path)
        with self._opened() as reader:
            first, last = reader.start_time, reader.end_time - 1
            self.topics = {
                name: Topic(name, topic.msgtype or "", topic.msgcount, first, last)
                for name, topic in reader.topics.items()
                if topic.msgcount
            }
        if not self.topics:
            raise InputError(f"{path}: holds no messages")

    @contextmanager
    def _opened(self) -> Iterator[AnyReader]:
        types = typestore()
        try:
            from rosbags.highlevel import AnyReader

            bound_rosbags()
            reader = AnyReader([_PlainSuffix(self.path)], default_typestore=types)
            reader.open()
            try:
                require_bounded_messages(reader.typestore.fielddefs)
            except InputError:
                reader.close()
                raise
        except Exception as error:  # whatever a parser makes of a broken bag
            raise InputError(f"{self.path}: can not be read ({_first_line(error)})") from error
        try:
            yield reader
        finally:
            reader.close()

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """See `Bag.messages`."""
        self.fault, self.damage, self.undecoded = None, None, Counter()
        with self._opened() as reader:
            wanted = [c for c in reader.connections if c.topic in topics]
            if not wanted:
                return

            def read(start: int) -> Iterator[tuple[int, tuple[Connection, bytes]]]:
                for connection, log_time, data in reader.messages(wanted, start):
                    yield log_time, (connection, data)

            found = ReadableStretches(read, reader.start_time, reader.end_time)
            for log_time, (connection, data) in found:
                try:
                    require_possible_size(connection.msgtype, len(data))
                    told = reader.deserialize(data, connection.msgtype)
                except Exception:  # whatever a parser makes of broken bytes
                    self.undecoded[connection.topic, connection.msgtype] += 1
                    continue
                yield BagMessage(connection.topic, log_time, told)
            if found.gaps:
                parts = f"{found.gaps} damaged part{'s' * (found.gaps > 1)}"
                self.damage = f"{parts}, {found.lost / NANOSECONDS:.1f} s"
            if found.broken_off and found.error is not None:
                self.fault = f"broken off: {_first_line(found.error)}"


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0].rstrip(".")
