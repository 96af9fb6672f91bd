"""ROS message types used in recordings, provided by rosbags."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from circumspect.errors import MissingExtraError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
ODOMETRY = "nav_msgs/msg/Odometry"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
DETECTIONS = "vision_msgs/msg/Detection3DArray"

# Fields of vision_msgs 4 (ros-perception/vision_msgs, branch ros2), which rosbags does not include.
_VISION = {
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score",
    "vision_msgs/msg/ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose"
    ),
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size",
    "vision_msgs/msg/Detection3D": (
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox3D bbox\nstring id"
    ),
    DETECTIONS: "std_msgs/Header header\nvision_msgs/Detection3D[] detections",
}


@cache
def typestore() -> Typestore:
    """Types of ROS 2 Jazzy and vision_msgs.

    Raises:
        MissingExtraError: rosbags is not installed.
    """
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError as error:
        raise MissingExtraError("rosbags", "bags") from error
    store = get_typestore(Stores.ROS2_JAZZY)
    types: dict[str, Any] = {}
    for name, definition in _VISION.items():
        types.update(get_types_from_msg(definition, name))
    store.register(types)
    return store


@cache
def ros1_typestore() -> Typestore:
    """Types of ROS 1 Noetic, including transforms.

    Raises:
        MissingExtraError: rosbags is not installed.
    """
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError as error:
        raise MissingExtraError("rosbags", "bags") from error
    store = get_typestore(Stores.ROS1_NOETIC)
    for name in (TRANSFORMS, "tf/msg/tfMessage"):
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", name))
    return store


def message(name: str, /, **fields: Any) -> Any:
    """Create a message.

    Args:
        name: Message type, such as `IMAGE`.
        fields: Values of all fields.
    """
    return typestore().types[name](**fields)
