"""Conversion of odometry and transforms to and from ROS messages."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.recording.ros_time import header, seconds
from circumspect.recording.ros_types import ODOMETRY, TRANSFORMS, message
from circumspect.sensing import Odometry

PLANAR = [0, 1, 5]
"""Indices of x, y and yaw in a 6-D ROS covariance."""
FARTHEST = 1e9
"""Maximum distance from the origin of a frame [m]."""


def odometry_message(odometry: Odometry, frame_id: str, child_frame_id: str) -> Any:
    """Encode odometry as `nav_msgs/Odometry`."""
    covariance = np.zeros((6, 6))
    covariance[np.ix_(PLANAR, PLANAR)] = odometry.covariance
    T, turn = odometry.T_odom_base.as_transform(), odometry.turn
    twist = message("geometry_msgs/msg/Twist", linear=vector_message([odometry.forward, 0, 0]),
                    angular=vector_message([0, 0, turn]))  # fmt: skip
    return message(
        ODOMETRY, header=header(odometry.stamp, frame_id), child_frame_id=child_frame_id,
        pose=message("geometry_msgs/msg/PoseWithCovariance", pose=pose_message(T),
                     covariance=covariance.ravel()),
        twist=message("geometry_msgs/msg/TwistWithCovariance", twist=twist,
                      covariance=np.zeros(36)),
    )  # fmt: skip


def odometry_of(msg: Any) -> Odometry:
    """Decode a `nav_msgs/Odometry`.

    Raises:
        InputError: Pose, stamp or velocity is not finite, or the quaternion is invalid.
    """
    pose, covariance = msg.pose.pose, np.reshape(msg.pose.covariance, (6, 6))
    T = transform_of(pose.position, pose.orientation)
    planar = covariance[np.ix_(PLANAR, PLANAR)]
    return Odometry(
        seconds(msg), PlanarPose.from_transform(T), (planar + planar.T) / 2,
        float(msg.twist.twist.linear.x), float(msg.twist.twist.angular.z),
    )  # fmt: skip


def transforms_message(transforms: list[Any]) -> Any:
    """Encode several `transform_message` as `tf2_msgs/TFMessage`."""
    return message(TRANSFORMS, transforms=transforms)


def transform_message(T: RigidTransform, stamp: float, target: str, source: str) -> Any:
    """Encode a transform as `geometry_msgs/TransformStamped`; it maps source into target."""
    transform = message("geometry_msgs/msg/Transform", translation=vector_message(T.translation),
                        rotation=_quaternion(T.rotation))  # fmt: skip
    return message("geometry_msgs/msg/TransformStamped", header=header(stamp, target),
                   child_frame_id=source, transform=transform)  # fmt: skip


def pose_message(T: RigidTransform) -> Any:
    """Encode a pose as `geometry_msgs/Pose`."""
    place = message("geometry_msgs/msg/Point", **_xyz(T.translation))
    return message("geometry_msgs/msg/Pose", position=place, orientation=_quaternion(T.rotation))


def transform_of(place: Any, orientation: Any) -> RigidTransform:
    """Decode a pose from a position or translation and a quaternion.

    Raises:
        InputError: It is not finite or too far away, or the quaternion is not normalised.
    """
    xyz = np.array([place.x, place.y, place.z])
    xyzw = np.array([orientation.x, orientation.y, orientation.z, orientation.w])
    length = math.hypot(*xyzw)  # Unlike NumPy's norm it cannot overflow.
    if not (np.abs(xyz) <= FARTHEST).all() or not abs(length - 1) < 0.01:
        at = [round(value, 3) for value in xyz.tolist()]
        raise InputError(f"an invalid pose at {at} with the quaternion {xyzw.tolist()}")
    return RigidTransform.from_components(xyz, Rotation.from_quat(xyzw))


def vector_message(xyz: Any) -> Any:
    """Encode a `geometry_msgs/Vector3`."""
    return message("geometry_msgs/msg/Vector3", **_xyz(xyz))


def _xyz(xyz: Any) -> dict[str, float]:
    return dict(zip("xyz", (float(value) for value in xyz), strict=True))


def _quaternion(rotation: Rotation) -> Any:
    names = zip("xyzw", rotation.as_quat().tolist(), strict=True)
    return message("geometry_msgs/msg/Quaternion", **dict(names))
