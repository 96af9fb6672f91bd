"""The graph of `ros2 node list` and `ros2 node info`, read beside the middleware."""

from __future__ import annotations

import time
from typing import Any

from circumspect.recording.ros_types import typestore
from circumspect.ros.dds_middleware import ENTITIES, TOPIC
from circumspect.ros.dds_types import serialized_type
from circumspect.ros.middleware import LATEST


class GraphReader:
    """Subscribes to `ros_discovery_info` in a domain that this process has joined already."""

    def __init__(self, domain: int) -> None:
        from cyclonedds.domain import DomainParticipant
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        from circumspect.ros.dds_middleware import _qos

        self._participant = DomainParticipant(domain)
        about = Topic(self._participant, TOPIC, serialized_type(ENTITIES))
        self._reader: Any = DataReader(self._participant, about, _qos(ENTITIES, LATEST))
        self._nodes: dict[str, tuple[int, int]] = {}

    def nodes(self) -> dict[str, tuple[int, int]]:
        """Full name of each node to the numbers of its readers and writers, as last received."""
        for sample in self._reader.take(64):
            if not sample.sample_info.valid_data:
                continue
            msg: Any = typestore().deserialize_cdr(sample.data, ENTITIES)
            for node in msg.node_entities_info_seq:
                name = f"{node.node_namespace.rstrip('/')}/{node.node_name}"
                counts = len(node.reader_gid_seq), len(node.writer_gid_seq)
                self._nodes[name] = counts
        return dict(self._nodes)

    def wait_for(self, name: str, counts: tuple[int, int], seconds: float = 60.0) -> None:
        """Wait until that node publishes these numbers of readers and writers."""
        until = time.monotonic() + seconds
        while (nodes := self.nodes()).get(name) != counts:
            assert time.monotonic() < until, f"{name} is not there; known: {nodes}"
            time.sleep(0.05)
