"""Messages of an MCAP file, by their encoding: those of ROS 2, of ROS 1 and of Foxglove."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from circumspect.recording.bounded_unpacking import unpacked
from circumspect.recording.foxglove_messages import FOXGLOVE, foxglove_decoder
from circumspect.recording.ros_types import ros1_typestore, typestore

Decoder = Callable[[bytes], Any]

KNOWN = "messages of ROS 2 as cdr, of ROS 1 as ros1, and of Foxglove as protobuf"
PACKED = b"\x28\xb5\x2f\xfd"
"""Begins what zstd packed; no message of ROS 2 begins so."""


def kind_of(schema: str) -> str:
    """The type of ROS 2 that messages with a schema become.

    Args:
        schema: Its name, such as "sensor_msgs/Image" of ROS 1 or "foxglove.RawImage"; others are
            returned as they are.
    """
    if schema in FOXGLOVE:
        return FOXGLOVE[schema]
    package, slash, name = schema.partition("/")
    return f"{package}/msg/{name}" if slash and "/" not in name else schema


def decoder_of(schema: str, encoding: str) -> Decoder | None:
    """What turns the bytes of a message into one of `kind_of(schema)`; None for unknown ones.

    Args:
        schema: Name of the schema.
        encoding: Of the messages.

    Raises:
        MissingExtraError: What reads Foxglove's messages is not installed.
    """
    kind = kind_of(schema)
    if encoding == "cdr" and kind in typestore().fielddefs:
        return lambda data: typestore().deserialize_cdr(_plain(data), kind)
    if encoding == "ros1" and kind in ros1_typestore().fielddefs:
        return lambda data: ros1_typestore().deserialize_ros1(data, kind)
    if encoding == "protobuf" and schema in FOXGLOVE:
        return foxglove_decoder(schema)
    return None


def _plain(data: bytes) -> bytes:
    """A message that a recorder may have packed by itself (`--compression-mode message`)."""
    return bytes(unpacked(data, "zstd")) if data.startswith(PACKED) else data
