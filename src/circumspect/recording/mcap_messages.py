"""Decoders of the messages in an MCAP file: ROS 2, ROS 1 and Foxglove."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np

from circumspect.errors import MissingExtraError
from circumspect.recording.bounded_decompression import decompressed
from circumspect.recording.ros_types import (
    CAMERA_INFO,
    COMPRESSED_IMAGE,
    IMAGE,
    ODOMETRY,
    TRANSFORMS,
    ros1_typestore,
    typestore,
)

Decoder = Callable[[bytes], Any]
SUPPORTED_ENCODINGS = "ROS 2 messages as cdr, ROS 1 messages as ros1, Foxglove messages as protobuf"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
"""Start of data compressed with zstd; no ROS 2 message starts with it."""
FOXGLOVE = {
    "foxglove.RawImage": IMAGE,
    "foxglove.CompressedImage": COMPRESSED_IMAGE,
    "foxglove.CameraCalibration": CAMERA_INFO,
    "foxglove.FrameTransform": TRANSFORMS,
    "foxglove.FrameTransforms": TRANSFORMS,
    "foxglove.Odometry": ODOMETRY,
}
"""Schema to the ROS type that its messages are converted to."""


def kind_of(schema: str) -> str:
    """The ROS 2 type that messages of a schema are converted to.

    Args:
        schema: Name such as "sensor_msgs/Image" (ROS 1) or "foxglove.RawImage"; other names are
            returned unchanged.
    """
    if schema in FOXGLOVE:
        return FOXGLOVE[schema]
    package, slash, name = schema.partition("/")
    return f"{package}/msg/{name}" if slash and "/" not in name else schema


def decoder_of(schema: str, encoding: str) -> Decoder | None:
    """The decoder of a schema, which yields messages of type `kind_of(schema)`; None if unknown.

    Args:
        schema: Name of the schema.
        encoding: Encoding of the messages.

    Raises:
        MissingExtraError: The Foxglove schemas are not installed.
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
    """Message data, decompressed if the recorder compressed them (`--compression-mode message`)."""
    return bytes(decompressed(data, "zstd")) if data.startswith(ZSTD_MAGIC) else data


def foxglove_decoder(schema: str) -> Callable[[bytes], Any]:
    """The decoder of a Foxglove schema, which yields messages with the fields of ROS.

    Args:
        schema: One of `FOXGLOVE`.

    Raises:
        MissingExtraError: foxglove-schemas-protobuf is not installed.
    """
    name = schema.removeprefix("foxglove.")
    try:
        # Types come from the library, not from the untrusted file.
        parsed = getattr(import_module(f"foxglove_schemas_protobuf.{name}_pb2"), name).FromString
    except ImportError as error:
        raise MissingExtraError("foxglove-schemas-protobuf", "bags") from error
    convert = _CONVERTERS[name]
    return lambda data: convert(parsed(data))


def _header(msg: Any, frame_id: str) -> SimpleNamespace:
    stamp = SimpleNamespace(sec=msg.timestamp.seconds, nanosec=msg.timestamp.nanos)
    return SimpleNamespace(stamp=stamp, frame_id=frame_id)


def _raw_image(msg: Any) -> SimpleNamespace:
    return SimpleNamespace(
        header=_header(msg, msg.frame_id), height=msg.height, width=msg.width,
        encoding=msg.encoding, step=msg.step, is_bigendian=0,
        data=np.frombuffer(msg.data, np.uint8),
    )  # fmt: skip


def _compressed_image(msg: Any) -> SimpleNamespace:
    data = np.frombuffer(msg.data, np.uint8)
    return SimpleNamespace(header=_header(msg, msg.frame_id), format=msg.format, data=data)


def _calibration(msg: Any) -> SimpleNamespace:
    return SimpleNamespace(
        header=_header(msg, msg.frame_id), height=msg.height, width=msg.width,
        distortion_model=msg.distortion_model, d=np.array(msg.D), k=np.array(msg.K),
        r=np.array(msg.R), p=np.array(msg.P), binning_x=0, binning_y=0,
    )  # fmt: skip


def _stamped_transform(msg: Any) -> SimpleNamespace:
    moved = SimpleNamespace(translation=msg.translation, rotation=msg.rotation)
    header = _header(msg, msg.parent_frame_id)
    return SimpleNamespace(header=header, child_frame_id=msg.child_frame_id, transform=moved)


def _transform(msg: Any) -> SimpleNamespace:
    return SimpleNamespace(transforms=[_stamped_transform(msg)])


def _transforms(msg: Any) -> SimpleNamespace:
    return SimpleNamespace(transforms=[_stamped_transform(one) for one in msg.transforms])


def _odometry(msg: Any) -> SimpleNamespace:
    twist = SimpleNamespace(linear=msg.linear_velocity, angular=msg.angular_velocity)
    covariance = np.array(msg.pose_covariance)
    if covariance.size != 36:
        covariance = np.zeros(36)
    return SimpleNamespace(
        header=_header(msg, msg.frame_id), child_frame_id=msg.body_frame_id,
        pose=SimpleNamespace(pose=msg.pose, covariance=covariance),
        twist=SimpleNamespace(twist=twist),
    )  # fmt: skip


_CONVERTERS: dict[str, Callable[[Any], SimpleNamespace]] = {
    "RawImage": _raw_image,
    "CompressedImage": _compressed_image,
    "CameraCalibration": _calibration,
    "FrameTransform": _transform,
    "FrameTransforms": _transforms,
    "Odometry": _odometry,
}
