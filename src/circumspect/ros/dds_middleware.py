"""ROS 2 communication over Cyclone DDS without a ROS installation."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from circumspect.errors import CircumspectError, InputError, MissingExtraError
from circumspect.recording.ros_types import message, typestore
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.middleware import LATEST, MessageCallback, Middleware, Quality
from circumspect.ros.names import dds_topic
from circumspect.ros.wire_messages import serialized

if TYPE_CHECKING:
    from cyclonedds.core import Qos
    from cyclonedds.sub import DataReader

WAKE_MS = 100
"""Interval at which the receiving thread checks for shutdown [ms]."""
BATCH_SIZE = 64
RELIABILITY = 11
POLICIES = {2: "durability", 4: "deadline", 8: "liveliness", RELIABILITY: "reliability"}
"""DDS policy numbers (2.2.3, table of QoS policies) to ROS names."""
_log = logging.getLogger(__name__)
TOPIC = "ros_discovery_info"
"""Name of the discovery topic in DDS, without the topic prefix."""
ENTITIES = "rmw_dds_common/msg/ParticipantEntitiesInfo"


class DdsMiddleware(Middleware):
    """A participant of a DDS domain with a thread that receives messages."""

    def __init__(self, settings: DdsSettings, node: str) -> None:
        """Join a domain.

        Args:
            settings: Domain and discovery.
            node: Full name shown by `ros2 node list`; "" for none.

        Raises:
            MissingExtraError: cyclonedds or rosbags is not installed.
            InputError: Cyclone DDS rejects its settings.
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
                f"Cyclone DDS can not join domain {settings.domain} ({_reason(error)}); check "
                "CYCLONEDDS_URI and ROS_AUTOMATIC_DISCOVERY_RANGE"
            ) from error
        self._dds_error = DDSException
        self._lock = threading.Lock()
        self._readers: list[tuple[str, DataReader[Any], MessageCallback]] = []
        self._endpoints: list[Any] = []
        self._node = node
        self._endpoint_guids: tuple[list[bytes], list[bytes]] = ([], [])
        self._graph = self._graph_writer() if node else None
        self._wait_set = WaitSet(self._participant)
        self._wake = GuardCondition(self._participant)
        self._wait_set.attach(self._wake)
        self._is_open = True
        self._thread = threading.Thread(target=self._receive, name="dds", daemon=True)
        self._thread.start()

    def subscribe(self, topic: str, kind: str, quality: Quality, callback: MessageCallback) -> None:
        """See `Middleware.subscribe`."""
        from cyclonedds.core import ReadCondition
        from cyclonedds.sub import DataReader

        with self._dds_errors(topic):
            topic_entity = self._topic(dds_topic(topic), kind)
            reader = DataReader(self._participant, topic_entity, _qos(kind, quality))
            condition = ReadCondition(reader, _any_state())
        with self._lock:
            self._readers.append((topic, reader, callback))
            self._endpoints += [topic_entity, reader, condition]
        self._wait_set.attach(condition)
        self._wake.set(True)
        self._update_graph(readers=[reader])

    def advertise(self, topic: str, kind: str, quality: Quality) -> Callable[[bytes], None]:
        """See `Middleware.advertise`."""
        from cyclonedds.pub import DataWriter

        from circumspect.ros.dds_types import serialized_type

        with self._dds_errors(topic):
            topic_entity = self._topic(dds_topic(topic), kind)
            writer: Any = DataWriter(self._participant, topic_entity, _qos(kind, quality))
        self._endpoints += [topic_entity, writer]
        self._update_graph(writers=[writer])
        sample = serialized_type(kind)

        def publish(data: bytes) -> None:
            if not self._is_open:
                return
            try:
                writer.write(sample(data))
            except self._dds_error as error:
                _log.warning("%s: a message could not be sent (%s)", topic, _reason(error))

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
        if not self._is_open:
            return
        self._is_open = False
        self._wake.set(True)
        self._thread.join()
        with self._lock:
            self._readers.clear()
        # Notify others now, not when the last reference to a writer is released.
        self._wait_set.__del__()
        self._participant.__del__()

    def _graph_writer(self) -> Any:
        """Writer of the message that lists the topics of the node."""
        from cyclonedds.pub import DataWriter

        with self._dds_errors(TOPIC):
            topic_entity = self._topic(TOPIC, ENTITIES)
            self._endpoints.append(topic_entity)
            return DataWriter(self._participant, topic_entity, _qos(ENTITIES, LATEST))

    def _update_graph(self, readers: Sequence[Any] = (), writers: Sequence[Any] = ()) -> None:
        from circumspect.ros.dds_types import serialized_type

        if self._graph is None:
            return
        self._endpoint_guids[0].extend(reader.guid.bytes for reader in readers)
        self._endpoint_guids[1].extend(writer.guid.bytes for writer in writers)
        msg = entities_message(self._participant.guid.bytes, self._node, *self._endpoint_guids)
        self._graph.write(serialized_type(ENTITIES)(serialized(ENTITIES, msg)))

    def _topic(self, name: str, kind: str) -> Any:
        from cyclonedds.topic import Topic

        from circumspect.ros.dds_types import serialized_type

        return Topic(self._participant, name, serialized_type(kind))

    @contextmanager
    def _dds_errors(self, topic: str) -> Iterator[None]:
        try:
            yield
        except self._dds_error as error:
            raise InputError(
                f"{topic}: Cyclone DDS rejects the topic ({_reason(error)})"
            ) from error

    def _receive(self) -> None:
        while self._is_open:
            self._wait_set.wait(WAKE_MS * 1_000_000)
            self._wake.set(False)
            with self._lock:
                readers = list(self._readers)
            for topic, reader, callback in readers:
                self._deliver(topic, reader, callback)

    def _deliver(self, topic: str, reader: DataReader[Any], callback: MessageCallback) -> None:
        try:
            samples = reader.take(BATCH_SIZE)
        except self._dds_error as error:
            _log.warning("%s: can not be read (%s)", topic, _reason(error))
            return
        for sample in samples:
            # A disappearing publisher leaves a sample without data.
            if not getattr(sample.sample_info, "valid_data", False):
                continue
            try:
                callback(sample.data)
            except CircumspectError as error:
                _log.warning("%s: %s", topic, error)
            except Exception:  # one message must not stop the thread
                _log.exception("%s: a message could not be processed", topic)


@cache
def _domain(number: int, config: str) -> Any:
    """A domain, created once per process."""
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
        # Since Iron, nodes exchange a hash of the type definition (REP 2011).
        Policy.Userdata(f"typehash={typestore().hash_rihs01(kind)};".encode()),
    )


def _reason(error: Exception) -> str:
    return str(error).split("Occurred")[0].strip().rstrip(".")


def entities_message(
    participant: bytes, node: str, readers: list[bytes], writers: list[bytes]
) -> Any:
    """Create a `rmw_dds_common/ParticipantEntitiesInfo` of a participant with one node.

    Args:
        participant: (16,) bytes of its GUID.
        node: Full name of the node.
        readers: GUIDs of its readers.
        writers: GUIDs of its writers.
    """
    namespace, name = node.rsplit("/", 1)
    info = message(
        "rmw_dds_common/msg/NodeEntitiesInfo", node_namespace=namespace or "/", node_name=name,
        reader_gid_seq=[_gid(guid) for guid in readers],
        writer_gid_seq=[_gid(guid) for guid in writers],
    )  # fmt: skip
    return message(ENTITIES, gid=_gid(participant), node_entities_info_seq=[info])


def _gid(guid: bytes) -> Any:
    return message("rmw_dds_common/msg/Gid", data=np.frombuffer(guid, np.uint8))
