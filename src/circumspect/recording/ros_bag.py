"""ROS 1 and ROS 2 bags, read with rosbags."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from circumspect.errors import InputError
from circumspect.recording.bag import Bag, BagMessage, Topic
from circumspect.recording.bag_safety import (
    require_bounded_messages,
    require_plain_bag,
    require_possible_size,
)
from circumspect.recording.bounded_decompression import bound_rosbags
from circumspect.recording.ros_time import NANOSECONDS
from circumspect.recording.ros_types import typestore

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection

Message = TypeVar("Message")
FIRST_STEP_NS = 1_000_000
"""First step of the search for the end of a damaged part, doubled each time [ns]."""
RESOLUTION_NS = 10_000_000
"""Resolution of the search [ns]."""


class ReadableSegments(Iterator[tuple[int, Message]]):
    """Iterates over messages and resumes after damaged parts.

    Attributes:
        gaps: Number of damaged parts so far.
        lost_ns: Total duration of the damaged parts [ns].
        error: Last reading error; None if there was none.
        is_truncated: Whether nothing was readable after the last error.
    """

    def __init__(self, read: Callable[[int], Iterator[tuple[int, Message]]], begin: int, end: int):
        """Start reading.

        Args:
            read: Yields times and messages from a given time on; may raise any exception.
            begin: Time of the first message [ns].
            end: Time after the last message [ns].
        """
        self._read, self._end = read, end
        self._found = read(begin)
        self._last = begin
        self.gaps = self.lost_ns = 0
        self.error: Exception | None = None
        self.is_truncated = False

    def __next__(self) -> tuple[int, Message]:
        while True:
            try:
                self._last, message = next(self._found)
            except StopIteration:
                raise
            except Exception as error:  # any error of a parser on a broken bag
                self.error = error
                self._skip()
                continue
            return self._last, message

    def _skip(self) -> None:
        before = self._last
        after = self._next_readable(before)
        if after is None:
            self.is_truncated = True
            self._found = iter(())
            return
        self.gaps += 1
        self.lost_ns += after - before
        self._found, self._last = self._read(after), after

    def _next_readable(self, last: int) -> int | None:
        failing, step = last, FIRST_STEP_NS
        while failing < self._end:
            if self._is_readable(good := last + step):
                break
            failing, step = last + step, 2 * step
        else:
            return None
        while good - failing > RESOLUTION_NS:
            middle = (failing + good) // 2
            if self._is_readable(middle):
                good = middle
            else:
                failing = middle
        return good

    def _is_readable(self, start: int) -> bool:
        try:
            next(self._read(start))
        except Exception:  # nothing is left, or see `__next__`
            return False
        return True


class _PlainSuffix(type(Path())):
    """A path with a lower-case suffix: rosbags recognises the format from it."""

    @property
    def suffix(self) -> str:
        return super().suffix.lower()


class RosBag(Bag):
    """A ROS 1 bag, a db3 file or a rosbag2 folder."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Open the bag and read its index.

        Raises:
            InputError: The bag cannot be read.
            MissingExtraError: rosbags is not installed.
        """
        self.path, self.notes, self.error, self.damage = Path(path), {}, None, None
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
            raise InputError(f"{path}: contains no messages")

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
        except Exception as error:  # any error of a parser on a broken bag
            raise InputError(f"{self.path}: can not be read ({_first_line(error)})") from error
        try:
            yield reader
        finally:
            reader.close()

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """See `Bag.messages`."""
        self.error, self.damage, self.undecoded = None, None, Counter()
        with self._opened() as reader:
            wanted = [c for c in reader.connections if c.topic in topics]
            if not wanted:
                return

            def read(start: int) -> Iterator[tuple[int, tuple[Connection, bytes]]]:
                for connection, log_time, data in reader.messages(wanted, start):
                    yield log_time, (connection, data)

            found = ReadableSegments(read, reader.start_time, reader.end_time)
            for log_time, (connection, data) in found:
                try:
                    require_possible_size(connection.msgtype, len(data))
                    msg = reader.deserialize(data, connection.msgtype)
                except Exception:  # any error of a parser on broken data
                    self.undecoded[connection.topic, connection.msgtype] += 1
                    continue
                yield BagMessage(connection.topic, log_time, msg)
            if found.gaps:
                parts = f"{found.gaps} damaged part{'s' * (found.gaps > 1)}"
                self.damage = f"{parts}, {found.lost_ns / NANOSECONDS:.1f} s"
            if found.is_truncated and found.error is not None:
                self.error = f"truncated: {_first_line(found.error)}"


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0].rstrip(".")
