"""Poses of the camera: registration to the scene, wheel odometry, pose graph."""

from circumspect.mapping.gate import GATE_OPEN
from circumspect.mapping.pose_estimator import KnownPoses, PoseEstimate, PoseEstimator
from circumspect.mapping.registered_poses import RegisteredPoses
from circumspect.mapping.tracking_settings import TrackingSettings

__all__ = [
    "GATE_OPEN",
    "KnownPoses",
    "PoseEstimate",
    "PoseEstimator",
    "RegisteredPoses",
    "TrackingSettings",
]
