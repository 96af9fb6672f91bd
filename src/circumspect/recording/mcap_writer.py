"""Writer of MCAP files that are readable at any time."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, cast

from circumspect.errors import MissingExtraError, OutputError, reason_of
from circumspect.recording.ros_types import typestore

CHUNK_BYTES = 1024
"""Size at which a chunk ends [bytes]; every image exceeds it."""
LATCHED = """- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: 1
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false"""
"""Quality of service of latched topics in rosbag2's format."""
SUFFIX = ".mcap"
"""Suffix of recordings."""
NOTES = "circumspect"
"""Name of the metadata record that holds the notes."""


class AtomicAppendFile:
    """Buffers written data and appends them to the file on `commit`.

    An incomplete append is removed again.
    """

    def __init__(self, path: Path) -> None:
        """Create a file.

        Raises:
            OSError: It exists or cannot be created.
        """
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
        self._size = 0
        self._pending = bytearray()
        self.closed = False

    def write(self, data: bytes) -> int:
        """Buffer data."""
        self._pending += data
        return len(data)

    def tell(self) -> int:
        """Size of the file including buffered data."""
        return self._size + len(self._pending)

    def flush(self) -> None:
        """Does nothing; see `commit`."""

    def commit(self) -> None:
        """Append the buffered data.

        After an interruption, such as Ctrl-C, the data can be committed again.

        Raises:
            OSError: The system refuses; the file is unchanged and closed.
        """
        rest = memoryview(self._pending)
        try:
            while len(rest):
                rest = rest[os.write(self._file, rest) :]
        except BaseException as error:
            os.ftruncate(self._file, self._size)
            os.lseek(self._file, self._size, os.SEEK_SET)
            if isinstance(error, OSError):
                self.close()
            raise
        finally:
            rest.release()
        self._size += len(self._pending)
        self._pending.clear()

    def sync(self) -> None:
        """Wait until the committed data are on disk.

        Raises:
            OSError: The data are not on disk.
        """
        os.fsync(self._file)

    def close(self) -> None:
        """Close the file; data that are not committed are lost."""
        if not self.closed:
            self.closed = True
            os.close(self._file)


class McapWriter:
    """Writes ROS 2 messages as they arrive.

    Small chunks are written immediately, so a killed process loses only its last messages. If the
    disk is full, the file is truncated to its last complete record.
    """

    def __init__(self, path: str | os.PathLike[str], notes: Mapping[str, str]) -> None:
        """Create a file.

        Args:
            path: New file; an existing recording is never overwritten.
            notes: Metadata to store with the messages.

        Raises:
            OutputError: The file exists, cannot be written, or has another suffix than `SUFFIX`.
            MissingExtraError: mcap or rosbags is not installed.
        """
        try:
            from mcap.writer import CompressionType, Writer
        except ImportError as error:
            raise MissingExtraError("mcap", "bags") from error
        self._types = typestore()
        self.path = Path(path)
        if self.path.suffix.lower() != SUFFIX:
            raise OutputError(f"{path}: recordings are MCAP files; end the name in {SUFFIX}")
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = AtomicAppendFile(self.path)
        except FileExistsError as error:
            raise OutputError(
                f"{path}: exists; recordings are never overwritten, choose another name"
            ) from error
        except OSError as error:
            raise self._write_error(error) from error
        self._writer = Writer(
            cast("BinaryIO", self._file), chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD
        )
        self._committed(lambda: self._begin(dict(notes)))

    def _begin(self, notes: dict[str, str]) -> None:
        self._writer.start(profile="ros2", library="circumspect")
        self._writer.add_metadata(NOTES, notes)

    def write(self, topic: str, kind: str, log_time: int, msg: Any, latched: bool = False) -> None:
        """Append a message.

        Args:
            topic: Topic name.
            kind: Message type, such as `ros_types.IMAGE`.
            log_time: Time at which the message was recorded [ns].
            msg: The message.
            latched: Whether late subscribers receive the last message of the topic.

        Raises:
            OutputError: The message cannot be written; earlier ones are kept, and the file is
                closed.
        """
        data = bytes(self._types.serialize_cdr(msg, kind))
        self._committed(lambda: self._append(topic, kind, log_time, data, latched))

    def _append(self, topic: str, kind: str, log_time: int, data: bytes, latched: bool) -> None:
        if topic not in self._channels:
            self._channels[topic] = self._writer.register_channel(
                topic, "cdr", self._schema(kind), {"offered_qos_profiles": LATCHED * latched}
            )
        self._writer.add_message(self._channels[topic], log_time, data, log_time)

    def _schema(self, kind: str) -> int:
        if kind not in self._schemas:
            definition, _ = self._types.generate_msgdef(kind, ros_version=2)
            self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", definition.encode())
        return self._schemas[kind]

    def close(self) -> None:
        """Write the index and close the file.

        Raises:
            OutputError: The index cannot be written; the messages are kept.
        """
        if not self._file.closed:
            self._committed(self._writer.finish)
            with suppress(OSError):  # Unsupported by pipes and some file systems.
                self._file.sync()
            self._file.close()

    def discard(self) -> None:
        """Remove the file of a recording that does not start."""
        self._file.close()
        self.path.unlink(missing_ok=True)

    def _committed(self, step: Callable[[], object]) -> None:
        """Run a step on the file and commit the result."""
        if self._file.closed:
            raise OutputError(f"{self.path}: the recording has ended")
        try:
            step()
            self._file.commit()
        except OSError as error:
            raise self._write_error(error) from error

    def _write_error(self, error: OSError) -> OutputError:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        reason = "the disk is full" if full else reason_of(error)
        return OutputError(
            f"{self.path}: recording has ended ({reason}); earlier messages are kept"
        )
