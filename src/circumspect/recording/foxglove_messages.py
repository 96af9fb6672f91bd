"""Foxglove's own messages, in the form of those of ROS."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np

from circumspect.errors import MissingExtraError
from circumspect.recording.ros_types import (
    CAMERA_INFO,
    COMPRESSED_IMAGE,
    IMAGE,
    ODOMETRY,
    TRANSFORMS,
)

FOXGLOVE = {
    "foxglove.RawImage": IMAGE,
    "foxglove.CompressedImage": COMPRESSED_IMAGE,
    "foxglove.CameraCalibration": CAMERA_INFO,
    "foxglove.FrameTransform": TRANSFORMS,
    "foxglove.FrameTransforms": TRANSFORMS,
    "foxglove.Odometry": ODOMETRY,
}
"""Schema to the type of ROS that its messages become."""


def foxglove_decoder(schema: str) -> Callable[[bytes], Any]:
    """What turns the bytes of a message into one like ROS's.

    Args:
        schema: One of `FOXGLOVE`.

    Raises:
        MissingExtraError: foxglove-schemas-protobuf is not installed.
    """
    name = schema.removeprefix("foxglove.")
    try:
        # The types are the library's own, not those that a stranger's file brings along.
        parsed = getattr(import_module(f"foxglove_schemas_protobuf.{name}_pb2"), name).FromString
    except ImportError as error:
        raise MissingExtraError("foxglove-schemas-protobuf", "bags") from error
    turned = _TURNED[name]
    return lambda data: turned(parsed(data))


def _header(told: Any, frame_id: str) -> SimpleNamespace:
    stamp = SimpleNamespace(sec=told.timestamp.seconds, nanosec=told.timestamp.nanos)
    return SimpleNamespace(stamp=stamp, frame_id=frame_id)


def _raw_image(told: Any) -> SimpleNamespace:
    return SimpleNamespace(
        header=_header(told, told.frame_id), height=told.height, width=told.width,
        encoding=told.encoding, step=told.step, is_bigendian=0,
        data=np.frombuffer(told.data, np.uint8),
    )  # fmt: skip


def _compressed_image(told: Any) -> SimpleNamespace:
    data = np.frombuffer(told.data, np.uint8)
    return SimpleNamespace(header=_header(told, told.frame_id), format=told.format, data=data)


def _calibration(told: Any) -> SimpleNamespace:
    return SimpleNamespace(
        header=_header(told, told.frame_id), height=told.height, width=told.width,
        distortion_model=told.distortion_model, d=np.array(told.D), k=np.array(told.K),
        r=np.array(told.R), p=np.array(told.P), binning_x=0, binning_y=0,
    )  # fmt: skip


def _stamped_transform(told: Any) -> SimpleNamespace:
    moved = SimpleNamespace(translation=told.translation, rotation=told.rotation)
    header = _header(told, told.parent_frame_id)
    return SimpleNamespace(header=header, child_frame_id=told.child_frame_id, transform=moved)


def _transform(told: Any) -> SimpleNamespace:
    return SimpleNamespace(transforms=[_stamped_transform(told)])


def _transforms(told: Any) -> SimpleNamespace:
    return SimpleNamespace(transforms=[_stamped_transform(one) for one in told.transforms])


def _odometry(told: Any) -> SimpleNamespace:
    twist = SimpleNamespace(linear=told.linear_velocity, angular=told.angular_velocity)
    covariance = np.array(told.pose_covariance)
    if covariance.size != 36:
        covariance = np.zeros(36)
    return SimpleNamespace(
        header=_header(told, told.frame_id), child_frame_id=told.body_frame_id,
        pose=SimpleNamespace(pose=told.pose, covariance=covariance),
        twist=SimpleNamespace(twist=twist),
    )  # fmt: skip


_TURNED: dict[str, Callable[[Any], SimpleNamespace]] = {
    "RawImage": _raw_image,
    "CompressedImage": _compressed_image,
    "CameraCalibration": _calibration,
    "FrameTransform": _transform,
    "FrameTransforms": _transforms,
    "Odometry": _odometry,
}
