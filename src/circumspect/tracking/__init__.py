"""Camera tracking: pose estimators, their settings, states and results."""

from circumspect.tracking.odometry_check import OdometryCheck
from circumspect.tracking.pose_estimate import PoseEstimate
from circumspect.tracking.pose_estimator import KnownPoses, PoseEstimator
from circumspect.tracking.tracker import Tracker
from circumspect.tracking.tracking_settings import TrackingSettings
from circumspect.tracking.tracking_state import TrackingState

__all__ = [
    "KnownPoses",
    "OdometryCheck",
    "PoseEstimate",
    "PoseEstimator",
    "Tracker",
    "TrackingSettings",
    "TrackingState",
]
