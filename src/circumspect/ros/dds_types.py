"""Types of ROS messages as DDS knows them; what they hold stays packed."""

from __future__ import annotations

from functools import cache
from typing import Any, ClassVar, Self

from rosbags.interfaces import Nodetype

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

    __idl__: ClassVar[Any]

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.sample_info: Any = None

    def serialize(self, **_: Any) -> bytes:
        """The bytes themselves: they were packed before."""
        return self.data

    @classmethod
    def deserialize(cls, data: bytes, **_: Any) -> Self:
        """Leave the bytes packed: whoever wants them unpacks them, with limits."""
        return cls(data)


@cache
def packed_type(kind: str) -> type[Packed]:
    """The class that the DDS library wants for a topic.

    Its declaration is the true one, so that peers which compare declarations agree with it.

    Args:
        kind: A message type such as "sensor_msgs/msg/Image".
    """
    from cyclonedds.idl import IdlStruct, make_idl_struct

    declared = make_idl_struct(_class_name(kind), dds_type(kind), _fields(kind))
    names = {"serialize": Packed.serialize, "deserialize": classmethod(Packed.deserialize.__func__)}
    names["__init__"] = Packed.__init__
    for name, what in names.items():
        setattr(declared, name, what)
    assert issubclass(declared, IdlStruct)
    return declared  # pyright: ignore[reportReturnType]


def dds_type(kind: str) -> str:
    """A type's name in DDS: "sensor_msgs::msg::dds_::Image_"."""
    package, folder, name = kind.split("/")
    return f"{package}::{folder}::dds_::{name}_"


def _class_name(kind: str) -> str:
    return kind.replace("/", "_")


@cache
def _declared(kind: str) -> Any:
    from cyclonedds.idl import make_idl_struct

    return make_idl_struct(_class_name(kind), dds_type(kind), _fields(kind))


def _fields(kind: str) -> dict[str, Any]:
    return {name: _field(what) for name, what in typestore().fielddefs[kind][1]}


def _field(what: Any) -> Any:
    from cyclonedds.idl import types

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
