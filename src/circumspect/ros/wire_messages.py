"""Serialization of ROS messages, and deserialization with limits."""

from __future__ import annotations

from typing import Any

from circumspect.errors import InputError
from circumspect.recording.ros_types import IMAGE, typestore
from circumspect.ros.dds_settings import MAX_SAMPLE_BYTES

MAX_BYTES = {IMAGE: MAX_SAMPLE_BYTES}
MAX_OTHER_BYTES = 2**20
"""Maximum size of other messages [bytes]; larger ones are mistaken or malicious."""
HEADER_BYTES = 4
"""Size of the encapsulation header [bytes]."""


def serialized(kind: str, msg: Any) -> bytes:
    """Serialize a message to CDR with encapsulation header.

    Args:
        kind: Message type, such as "nav_msgs/msg/Path".
        msg: The message.
    """
    return bytes(typestore().serialize_cdr(msg, kind))


def deserialized(kind: str, data: bytes) -> Any:
    """Deserialize a CDR message.

    Args:
        kind: Expected message type.
        data: CDR of either byte order, with encapsulation header.

    Raises:
        InputError: The data are not of that type, or too large.
    """
    if len(data) > MAX_BYTES.get(kind, MAX_OTHER_BYTES):
        raise InputError(f"a {kind} of {len(data)} bytes is too large")
    if len(data) <= HEADER_BYTES or data[0] != 0 or data[1] > 1:
        raise InputError(f"a {kind} is not in plain CDR")
    try:
        return typestore().deserialize_cdr(data, kind)
    except Exception as error:  # any error of a parser on broken data
        raise InputError(f"the data are not a {kind}") from error
