"""Messages that the node publishes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.recording.pose_messages import pose_message
from circumspect.recording.ros_time import header
from circumspect.recording.ros_types import DETECTIONS, message

POINTS = "sensor_msgs/msg/PointCloud2"
PATH = "nav_msgs/msg/Path"
POSE = "geometry_msgs/msg/PoseStamped"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
EMPTY = "std_msgs/msg/Empty"
FIELDS = ("x", "y", "z", "normal_x", "normal_y", "normal_z")
FLOAT32 = 7
"""Type number in `sensor_msgs/PointField`."""


def points_message(
    points_xyz: NDArray[np.floating],
    normals_xyz: NDArray[np.floating] | None,
    stamp: float,
    frame_id: str,
) -> Any:
    """Create a `sensor_msgs/PointCloud2` with normals.

    Args:
        points_xyz: (n, 3) [m]; may be empty.
        normals_xyz: (n, 3) unit normals, or None.
        stamp: Time [s].
        frame_id: Frame of the points.
    """
    normals = np.zeros_like(points_xyz) if normals_xyz is None else normals_xyz
    table = np.hstack([points_xyz, normals]).astype("<f4")
    fields = [
        message("sensor_msgs/msg/PointField", name=name, offset=4 * at, datatype=FLOAT32, count=1)
        for at, name in enumerate(FIELDS)
    ]
    data = np.frombuffer(table.tobytes(), np.uint8)
    return message(
        POINTS, header=header(stamp, frame_id), height=1, width=len(table), fields=fields,
        is_bigendian=False, point_step=4 * len(FIELDS), row_step=len(data), data=data,
        is_dense=True,
    )  # fmt: skip


def path_message(poses: Iterable[tuple[float, RigidTransform]], stamp: float, frame_id: str) -> Any:
    """Create a `nav_msgs/Path` of poses with stamps [s]."""
    stamped = [stamped_pose(pose, at, frame_id) for at, pose in poses]
    return message(PATH, header=header(stamp, frame_id), poses=stamped)


def stamped_pose(pose: RigidTransform, stamp: float, frame_id: str) -> Any:
    """Create a `geometry_msgs/PoseStamped`."""
    return message(POSE, header=header(stamp, frame_id), pose=pose_message(pose))


def no_pose(stamp: float) -> Any:
    """Create a `geometry_msgs/PoseStamped` that withdraws the previous one.

    It has no frame, and its position is NaN, so that it can be neither transformed nor used as a
    goal. The message type has no empty value.

    Args:
        stamp: Time [s].
    """
    return stamped_pose(RigidTransform.from_translation(np.full(3, np.nan)), stamp, "")


def no_detections(stamp: float, frame_id: str) -> Any:
    """Create an empty `vision_msgs/Detection3DArray`, which withdraws the previous one."""
    return message(DETECTIONS, header=header(stamp, frame_id), detections=[])


def diagnostics_message(
    level: int, name: str, text: str, hardware_id: str, values: Mapping[str, Any], stamp: float
) -> Any:
    """Create a `diagnostic_msgs/DiagnosticArray` with one status.

    Args:
        level: 0 OK, 1 warning, 2 error.
        name: Name of the component.
        text: Description of the status.
        hardware_id: Hardware, such as the topic of the camera.
        values: Additional values.
        stamp: Time [s].
    """
    pairs = [
        message("diagnostic_msgs/msg/KeyValue", key=key, value=str(value))
        for key, value in values.items()
    ]
    status = message(
        "diagnostic_msgs/msg/DiagnosticStatus", level=level, name=name, message=text,
        hardware_id=hardware_id, values=pairs,
    )  # fmt: skip
    return message(DIAGNOSTICS, header=header(stamp, ""), status=[status])
