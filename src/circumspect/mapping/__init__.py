"""From frames to one model of the object: poses, fusion, the rays that saw it."""

from circumspect.mapping.gate import GATE_OPEN
from circumspect.mapping.object_model import ModelSettings, ObjectModel
from circumspect.mapping.pose_estimator import KnownPoses, PoseEstimate, PoseEstimator
from circumspect.mapping.registered_poses import RegisteredPoses, TrackingSettings
from circumspect.mapping.sight_rays import SightRays

__all__ = [
    "GATE_OPEN",
    "KnownPoses",
    "ModelSettings",
    "ObjectModel",
    "PoseEstimate",
    "PoseEstimator",
    "RegisteredPoses",
    "SightRays",
    "TrackingSettings",
]
