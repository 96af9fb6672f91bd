"""Messages packed for the wire, and unpacked with limits."""

from __future__ import annotations

from typing import Any

from circumspect.errors import InputError
from circumspect.recording.ros_types import IMAGE, typestore
from circumspect.ros.dds_settings import LARGEST_SAMPLE

LARGEST = {IMAGE: LARGEST_SAMPLE}
LARGEST_OTHER = 2**20
"""Bytes of a message; what is larger was not meant for us, or is meant to harm."""
HEAD = 4
"""Bytes of the encapsulation header."""


def packed(kind: str, told: Any) -> bytes:
    """A message as CDR, encapsulation header first.

    Args:
        kind: Its type, such as "nav_msgs/msg/Path".
        told: The message.
    """
    return bytes(typestore().serialize_cdr(told, kind))


def unpacked(kind: str, data: bytes) -> Any:
    """The message that CDR holds.

    Args:
        kind: The type it should be of.
        data: Encapsulation header first; either byte order.

    Raises:
        InputError: It is none of that type, or larger than any such message.
    """
    if len(data) > LARGEST.get(kind, LARGEST_OTHER):
        raise InputError(f"a {kind} of {len(data)} bytes is left out")
    if len(data) <= HEAD or data[0] != 0 or data[1] > 1:
        raise InputError(f"a {kind} that is not in plain CDR is left out")
    try:
        return typestore().deserialize_cdr(data, kind)
    except Exception as error:  # whatever a parser makes of broken bytes
        raise InputError(f"bytes that are no {kind} are left out") from error
