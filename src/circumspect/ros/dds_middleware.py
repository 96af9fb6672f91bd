"""ROS 2 without ROS: messages straight over DDS, by Cyclone DDS."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any

from circumspect.errors import CircumspectError, InputError, MissingExtraError
from circumspect.recording.ros_types import typestore
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.middleware import LATEST, Heard, Middleware, Quality
from circumspect.ros.names import dds_topic
from circumspect.ros.node_graph import ENTITIES, TOPIC, entities_message
from circumspect.ros.wire_messages import packed

if TYPE_CHECKING:
    from cyclonedds.core import Qos
    from cyclonedds.sub import DataReader

WAKE_MS = 100
"""So often the receiving thread looks whether it is to end [ms]."""
BATCH = 64
RELIABILITY = 11
POLICIES = {2: "durability", 4: "deadline", 8: "liveliness", RELIABILITY: "reliability"}
"""Numbers of DDS (2.2.3, table of QoS policies) to the words of ROS."""

_log = logging.getLogger(__name__)


class DdsMiddleware(Middleware):
    """A participant of a DDS domain, and the thread in which messages are heard."""

    def __init__(self, settings: DdsSettings, node: str) -> None:
        """Join a domain.

        Args:
            settings: Where the others are.
            node: Full name under which `ros2 node list` shows it; "" for none.

        Raises:
            MissingExtraError: cyclonedds or rosbags is not installed.
            InputError: Cyclone DDS refuses its settings.
        """
        try:
            from cyclonedds.core import DDSException, GuardCondition, WaitSet
            from cyclonedds.domain import DomainParticipant
            from cyclonedds.qos import Policy, Qos
        except ImportError as error:
            raise MissingExtraError("cyclonedds", "ros2") from error
        typestore()
        try:
            self._domain = _domain(settings.domain, settings.cyclone())
            self._participant: Any = DomainParticipant(
                settings.domain, Qos(Policy.Userdata(b"enclave=/;"))
            )
        except DDSException as error:
            raise InputError(
                f"Cyclone DDS can not join domain {settings.domain} ({_said(error)}); see "
                "CYCLONEDDS_URI and ROS_AUTOMATIC_DISCOVERY_RANGE"
            ) from error
        self._refused = DDSException
        self._lock = threading.Lock()
        self._readers: list[tuple[str, DataReader[Any], Heard]] = []
        self._endpoints: list[Any] = []
        self._node = node
        self._guids: tuple[list[bytes], list[bytes]] = ([], [])
        self._graph = self._announced() if node else None
        self._waiting = WaitSet(self._participant)
        self._wake = GuardCondition(self._participant)
        self._waiting.attach(self._wake)
        self._going = True
        self._thread = threading.Thread(target=self._listen, name="dds", daemon=True)
        self._thread.start()

    def subscribe(self, topic: str, kind: str, quality: Quality, heard: Heard) -> None:
        """See `Middleware.subscribe`."""
        from cyclonedds.core import ReadCondition
        from cyclonedds.sub import DataReader

        with self._refusals(topic):
            about = self._topic(dds_topic(topic), kind)
            reader = DataReader(self._participant, about, _qos(kind, quality))
            condition = ReadCondition(reader, _any_state())
        with self._lock:
            self._readers.append((topic, reader, heard))
            self._endpoints += [about, reader, condition]
        self._waiting.attach(condition)
        self._wake.set(True)
        self._announce(readers=[reader])

    def advertise(self, topic: str, kind: str, quality: Quality) -> Callable[[bytes], None]:
        """See `Middleware.advertise`."""
        from cyclonedds.pub import DataWriter

        from circumspect.ros.dds_types import packed_type

        with self._refusals(topic):
            about = self._topic(dds_topic(topic), kind)
            writer: Any = DataWriter(self._participant, about, _qos(kind, quality))
        self._endpoints += [about, writer]
        self._announce(writers=[writer])
        sample = packed_type(kind)

        def publish(data: bytes) -> None:
            if not self._going:
                return
            try:
                writer.write(sample(data))
            except self._refused as error:
                _log.warning("%s: a message could not be sent (%s)", topic, _said(error))

        return publish

    def publishers(self, topic: str) -> int:
        """See `Middleware.publishers`."""
        return max((len(r.get_matched_publications()) for r in self._readers_of(topic)), default=0)

    def incompatible(self, topic: str) -> str:
        """See `Middleware.incompatible`."""
        if self.publishers(topic):
            return ""
        found = [
            reader.get_requested_incompatible_qos_status() for reader in self._readers_of(topic)
        ]
        if not found or not all(status.total_count for status in found):
            return ""
        policies = [status.last_policy_id for status in found]
        first = RELIABILITY if RELIABILITY in policies else policies[0]
        return POLICIES.get(first, f"policy {first}")

    def _readers_of(self, topic: str) -> list[DataReader[Any]]:
        with self._lock:
            return [reader for name, reader, _ in self._readers if name == topic]

    @property
    def lost(self) -> int:
        """See `Middleware.lost`."""
        with self._lock:
            readers = [reader for _, reader, _ in self._readers]
        return sum(reader.get_sample_lost_status().total_count for reader in readers)

    def close(self) -> None:
        """See `Middleware.close`."""
        if not self._going:
            return
        self._going = False
        self._wake.set(True)
        self._thread.join()
        with self._lock:
            self._readers.clear()
        # Others are to notice now, not when the last reference to a writer goes.
        self._waiting.__del__()
        self._participant.__del__()

    def _announced(self) -> Any:
        """The writer that tells which topics are the node's."""
        from cyclonedds.pub import DataWriter

        with self._refusals(TOPIC):
            about = self._topic(TOPIC, ENTITIES)
            self._endpoints.append(about)
            return DataWriter(self._participant, about, _qos(ENTITIES, LATEST))

    def _announce(self, readers: Sequence[Any] = (), writers: Sequence[Any] = ()) -> None:
        from circumspect.ros.dds_types import packed_type

        if self._graph is None:
            return
        self._guids[0].extend(reader.guid.bytes for reader in readers)
        self._guids[1].extend(writer.guid.bytes for writer in writers)
        told = entities_message(self._participant.guid.bytes, self._node, *self._guids)
        self._graph.write(packed_type(ENTITIES)(packed(ENTITIES, told)))

    def _topic(self, name: str, kind: str) -> Any:
        from cyclonedds.topic import Topic

        from circumspect.ros.dds_types import packed_type

        return Topic(self._participant, name, packed_type(kind))

    @contextmanager
    def _refusals(self, topic: str) -> Iterator[None]:
        try:
            yield
        except self._refused as error:
            raise InputError(f"{topic}: Cyclone DDS refuses it ({_said(error)})") from error

    def _listen(self) -> None:
        while self._going:
            self._waiting.wait(WAKE_MS * 1_000_000)
            self._wake.set(False)
            with self._lock:
                readers = list(self._readers)
            for topic, reader, heard in readers:
                self._hear(topic, reader, heard)

    def _hear(self, topic: str, reader: DataReader[Any], heard: Heard) -> None:
        try:
            samples = reader.take(BATCH)
        except self._refused as error:
            _log.warning("%s: can not be read (%s)", topic, _said(error))
            return
        for sample in samples:
            # A publisher that goes leaves a sample without data.
            if not getattr(sample.sample_info, "valid_data", False):
                continue
            try:
                heard(sample.data)
            except CircumspectError as error:
                _log.warning("%s: %s", topic, error)
            except Exception:  # one message must not make the node deaf
                _log.exception("%s: a message could not be worked on", topic)


@cache
def _domain(number: int, config: str) -> Any:
    """A domain is set up once in a process, and stays."""
    from cyclonedds.domain import Domain

    return Domain(number, config)


def _any_state() -> int:
    from cyclonedds.core import InstanceState, SampleState, ViewState

    return SampleState.NotRead | ViewState.Any | InstanceState.Any


def _qos(kind: str, quality: Quality) -> Qos:
    from cyclonedds.qos import Policy, Qos

    reliable = Policy.Reliability.Reliable(max_blocking_time=100_000_000)
    return Qos(
        reliable if quality.reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if quality.latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(quality.depth),
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
        # Since Iron, nodes tell each other by a hash how they understand a type (REP 2011).
        Policy.Userdata(f"typehash={typestore().hash_rihs01(kind)};".encode()),
    )


def _said(error: Exception) -> str:
    return str(error).split("Occurred")[0].strip().rstrip(".")
