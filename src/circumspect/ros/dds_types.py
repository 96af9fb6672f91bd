"""Types of ROS messages as DDS knows them; what they hold stays packed."""

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
"""ROS's names of scalars to those of the DDS library; a ROS `char` has no sign and is a number."""


class Packed:
    """A message as it goes over the wire, encapsulation header first."""

    sample_info: Any
    """What the DDS library tells of a message that was heard."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    def serialize(self, **_: Any) -> bytes:
        """The bytes themselves: they were packed before."""
        return self.data

    @classmethod
    def deserialize(cls, data: bytes, **_: Any) -> Self:
        """Leave the bytes packed: whoever wants them unpacks them, with limits."""
        return cls(data)

    @classmethod
    def deserialize_key(cls, data: bytes, **_: Any) -> Self:
        """The same, of what a publisher leaves behind when it goes."""
        return cls(data)


@cache
def packed_type(kind: str) -> Any:
    """The class that the DDS library wants for a topic: its messages are `Packed`.

    Its declaration is the true one, so that peers which compare declarations agree with it.

    Args:
        kind: A message type such as "sensor_msgs/msg/Image".
    """
    declared: Any = _declared(kind)
    for name in ("__init__", "serialize", "deserialize", "deserialize_key"):
        setattr(declared, name, Packed.__dict__[name])
    return declared


def dds_type(kind: str) -> str:
    """A type's name in DDS: "sensor_msgs::msg::dds_::Image_"."""
    package, folder, name = kind.split("/")
    return f"{package}::{folder}::dds_::{name}_"


@cache
def _declared(kind: str) -> Any:
    from cyclonedds.idl import make_idl_struct

    return make_idl_struct(kind.replace("/", "_"), dds_type(kind), _fields(kind))


def _fields(kind: str) -> dict[str, Any]:
    return {name: _field(what) for name, what in typestore().fielddefs[kind][1]}


def _field(what: Any) -> Any:
    from cyclonedds.idl import types
    from rosbags.interfaces import Nodetype

    shape, detail = what
    match shape:
        case Nodetype.BASE:
            scalar = SCALARS[detail[0]]
            return getattr(types, scalar) if isinstance(scalar, str) else scalar
        case Nodetype.NAME:
            return _declared(detail)
        case Nodetype.ARRAY:
            return types.array[_field(detail[0]), detail[1]]
        case _:
            inner, bound = _field(detail[0]), detail[1]
            return types.sequence[inner, bound] if bound else types.sequence[inner]
