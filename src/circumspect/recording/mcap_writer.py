"""An MCAP file that is whole at every moment."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, cast

from circumspect.errors import MissingExtraError, OutputError, reason_of
from circumspect.recording.ros_types import typestore
from circumspect.recording.whole_file import WholeFile

CHUNK = 1024
"""A chunk ends once it holds so many bytes: with every image, for images are larger."""
LATCHED = """- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: 1
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false"""
"""Quality of service of a topic whose last message latecomers get, in rosbag2's words."""
SUFFIX = ".mcap"
"""By it a recording is known again."""
NOTES = "circumspect"
"""Name of the metadata record with the notes."""


class McapWriter:
    """Writes messages of ROS 2 as they come.

    Chunks are small and go to the file at once, so that a process that is killed leaves all but
    its last messages readable. Where the disk is full the file is cut back to its last whole
    record.
    """

    def __init__(self, path: str | os.PathLike[str], notes: Mapping[str, str]) -> None:
        """Begin a new file.

        Args:
            path: Must not exist: an earlier recording is never written over.
            notes: Kept with the messages.

        Raises:
            OutputError: The file exists, can not be written, or is not named as MCAP files are.
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
            self._file = WholeFile(self.path)
        except FileExistsError as error:
            raise OutputError(
                f"{path}: exists; a recording is never written over, take another name"
            ) from error
        except OSError as error:
            raise self._fault(error) from error
        self._writer = Writer(
            cast("BinaryIO", self._file), chunk_size=CHUNK, compression=CompressionType.ZSTD
        )
        self._kept(lambda: self._begin(dict(notes)))

    def _begin(self, notes: dict[str, str]) -> None:
        self._writer.start(profile="ros2", library="circumspect")
        self._writer.add_metadata(NOTES, notes)

    def write(self, topic: str, kind: str, log_time: int, told: Any, latched: bool = False) -> None:
        """Append a message.

        Args:
            topic: Its name.
            kind: Its type, such as `ros_types.IMAGE`.
            log_time: When it was heard [ns].
            told: The message.
            latched: Latecomers get the topic's last message.

        Raises:
            OutputError: It can not be written; the file holds what came before, and is closed.
        """
        data = bytes(self._types.serialize_cdr(told, kind))
        self._kept(lambda: self._append(topic, kind, log_time, data, latched))

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
            OutputError: The index can not be written; the messages are kept.
        """
        if not self._file.closed:
            self._kept(self._writer.finish)
            with suppress(OSError):  # Pipes and some file systems can not; the messages are there.
                self._file.sync()
            self._file.close()

    def discard(self) -> None:
        """Remove the file: what it was meant for does not begin."""
        self._file.close()
        self.path.unlink(missing_ok=True)

    def _kept(self, step: Callable[[], object]) -> None:
        """Do something to the file; what was whole stays whole."""
        if self._file.closed:
            raise OutputError(f"{self.path}: the recording has ended")
        try:
            step()
            self._file.keep()
        except OSError as error:
            raise self._fault(error) from error

    def _fault(self, error: OSError) -> OutputError:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        reason = "the disk is full" if full else reason_of(error)
        return OutputError(
            f"{self.path}: recording has ended ({reason}); what was recorded before is kept"
        )
