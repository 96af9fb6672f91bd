"""What lets `ros2 node list` see the node: which topics of a participant are whose."""

from __future__ import annotations

from typing import Any

import numpy as np

from circumspect.recording.ros_types import message

TOPIC = "ros_discovery_info"
"""Its name in DDS, without the prefix of topics."""
ENTITIES = "rmw_dds_common/msg/ParticipantEntitiesInfo"


def entities_message(
    participant: bytes, node: str, readers: list[bytes], writers: list[bytes]
) -> Any:
    """A `rmw_dds_common/ParticipantEntitiesInfo` of a participant with one node.

    Args:
        participant: (16,) bytes of its GUID.
        node: The node's full name.
        readers: GUIDs of what it subscribes to.
        writers: GUIDs of what it publishes.
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
