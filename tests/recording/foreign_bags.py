"""Bags as other programs write them: a driving robot's messages, as ROS 1, db3 and MCAP."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from bag_world import CAMERA, MOUNT, frame
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.recording.image_messages import camera_info, depth_message
from circumspect.recording.pose_messages import (
    odometry_message,
    transform_message,
    transforms_message,
)
from circumspect.recording.ros_types import CAMERA_INFO, IMAGE, ODOMETRY, TRANSFORMS, typestore
from circumspect.robot import arc
from circumspect.sensing import Odometry

COUNT = 6
TimedMessage = tuple[str, str, float, Any]
"""Topic, type, time [s], message; or bytes in its place."""


def driven(stamp: float) -> PlanarPose:
    """An even arc."""
    return PlanarPose(0.0, 0.0, 0.4) @ arc(0.2 * stamp, 0.5 * stamp)


def robots_messages(depth: str = "/camera/depth/image_raw") -> list[TimedMessage]:
    """A robot whose odometry and images have different stamps; the mount is in two links."""
    half = RigidTransform.from_translation([0.0, 0.0, 0.5])
    links = [
        transform_message(half, 0.0, "base_footprint", "mast"),
        transform_message(half.inv() * MOUNT, 0.0, "mast", "xtion"),
    ]
    messages: list[TimedMessage] = [("/tf_static", TRANSFORMS, 0.0, transforms_message(links))]
    space = depth.rsplit("/", 1)[0]
    for number in range(COUNT):
        stamp = 0.1 * number
        messages.append(
            (f"{space}/camera_info", CAMERA_INFO, stamp, camera_info(CAMERA, stamp, "xtion"))
        )
        messages.append((depth, IMAGE, stamp, depth_message(frame(number).depth, stamp, "xtion")))
    for number in range(20):
        stamp = 0.04 * number
        odometry = Odometry(stamp, driven(stamp), stamp * np.eye(3))
        messages.append(
            ("/odom", ODOMETRY, stamp, odometry_message(odometry, "odom", "base_footprint"))
        )
    return sorted(messages, key=lambda one: one[2])


def without(messages: list[TimedMessage], topic: str) -> list[TimedMessage]:
    return [one for one in messages if one[0] != topic]


def written2(path: Path, messages: list[TimedMessage], plugin: StoragePlugin) -> Path:
    store = typestore()
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        topics: dict[str, Any] = {}
        for topic, kind, time, message in messages:
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            data = message if isinstance(message, bytes) else store.serialize_cdr(message, kind)
            writer.write(topics[topic], round(time * 1e9), data)
    return path


def written1(path: Path, messages: list[TimedMessage]) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))
    with Writer1(path) as writer:
        topics: dict[str, Any] = {}
        for topic, kind, time, message in messages:
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            data = message
            if not isinstance(message, bytes):
                data = store.serialize_ros1(as_ros1(store, message, kind), kind)
            writer.write(topics[topic], round(time * 1e9) + 1, data)
    return path


def as_ros1(store: Any, message: Any, kind: str) -> Any:
    """The same message in ROS 1's types: a header has a count, CameraInfo's fields are capitals."""
    fields = {}
    for name, (node, detail) in store.fielddefs[kind][1]:
        value = getattr(message, name if hasattr(message, name) else name.lower(), 0)
        if node.name == "NAME" and kind != "std_msgs/msg/Header":
            value = as_ros1(store, value, detail)
        elif node.name in ("ARRAY", "SEQUENCE") and detail[0][0].name == "NAME":
            value = [as_ros1(store, one, detail[0][1]) for one in value]
        fields[name] = value
    return store.types[kind](**fields)


def db3(folder: Path, messages: list[TimedMessage]) -> Path:
    return written2(folder / "bag", messages, StoragePlugin.SQLITE3)


def db3_file(folder: Path, messages: list[TimedMessage]) -> Path:
    return next(db3(folder, messages).glob("*.db3"))


def mcap(folder: Path, messages: list[TimedMessage]) -> Path:
    return next(written2(folder / "bag", messages, StoragePlugin.MCAP).glob("*.mcap"))


def ros1(folder: Path, messages: list[TimedMessage]) -> Path:
    return written1(folder / "robot.bag", messages)


Write = Callable[[Path, list[TimedMessage]], Path]
FORMATS = [db3, db3_file, mcap, ros1]
