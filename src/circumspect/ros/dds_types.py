"""DDS types of ROS messages, whose content stays serialized."""

from __future__ import annotations

from functools import cache
from typing import Any, Self

from circumspect.recording.ros_types import typestore

SCALARS = {
    "bool": bool,
    "float32": "float32",
    "float64": "float64",
    "string": str,
    **{name: name for name in ("int8", "int16", "int32", "int64", "byte")},
    **{name: name for name in ("uint8", "uint16", "uint32", "uint64")},
    "char": "uint8",
}
"""ROS scalar types to those of the DDS library; a ROS `char` is an unsigned number."""


class SerializedMessage:
    """A serialized message including its encapsulation header."""

    sample_info: Any
    """Information of the DDS library on a received message."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    def serialize(self, **_: Any) -> bytes:
        """Return the bytes, which are already serialized."""
        return self.data

    @classmethod
    def deserialize(cls, data: bytes, **_: Any) -> Self:
        """Keep the bytes; `wire_messages.deserialized` decodes them with limits."""
        return cls(data)

    @classmethod
    def deserialize_key(cls, data: bytes, **_: Any) -> Self:
        """Keep the bytes of the sample that a disappearing publisher leaves."""
        return cls(data)


@cache
def serialized_type(kind: str) -> Any:
    """The DDS class of a topic, whose messages are `SerializedMessage`.

    It has the true type declaration, so that peers that compare declarations accept it.

    Args:
        kind: Message type, such as "sensor_msgs/msg/Image".
    """
    idl_type: Any = _idl_struct(kind)
    for name in ("__init__", "serialize", "deserialize", "deserialize_key"):
        setattr(idl_type, name, SerializedMessage.__dict__[name])
    return idl_type


def dds_type(kind: str) -> str:
    """The DDS name of a type: "sensor_msgs::msg::dds_::Image_"."""
    package, folder, name = kind.split("/")
    return f"{package}::{folder}::dds_::{name}_"


@cache
def _idl_struct(kind: str) -> Any:
    from cyclonedds.idl import make_idl_struct

    return make_idl_struct(kind.replace("/", "_"), dds_type(kind), _fields(kind))


def _fields(kind: str) -> dict[str, Any]:
    return {name: _field(field_type) for name, field_type in typestore().fielddefs[kind][1]}


def _field(field_type: Any) -> Any:
    from cyclonedds.idl import types
    from rosbags.interfaces import Nodetype

    shape, detail = field_type
    match shape:
        case Nodetype.BASE:
            scalar = SCALARS[detail[0]]
            return getattr(types, scalar) if isinstance(scalar, str) else scalar
        case Nodetype.NAME:
            return _idl_struct(detail)
        case Nodetype.ARRAY:
            return types.array[_field(detail[0]), detail[1]]
        case _:
            inner, bound = _field(detail[0]), detail[1]
            return types.sequence[inner, bound] if bound else types.sequence[inner]
