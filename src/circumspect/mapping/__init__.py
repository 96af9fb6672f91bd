"""From frames to one model of the object: poses, fusion, the rays that saw it."""

from circumspect.mapping.frame_share import FrameShare
from circumspect.mapping.frame_surface import FrameSurface
from circumspect.mapping.gate import GATE_OPEN
from circumspect.mapping.object_model import ModelSettings, ObjectModel
from circumspect.mapping.object_views import ObjectViews
from circumspect.mapping.pose_estimator import KnownPoses, PoseEstimate, PoseEstimator
from circumspect.mapping.rebuild import Rebuild
from circumspect.mapping.registered_poses import RegisteredPoses
from circumspect.mapping.sight_rays import SightRays
from circumspect.mapping.tracking_settings import TrackingSettings

__all__ = [
    "GATE_OPEN",
    "FrameShare",
    "FrameSurface",
    "KnownPoses",
    "ModelSettings",
    "ObjectModel",
    "ObjectViews",
    "PoseEstimate",
    "PoseEstimator",
    "Rebuild",
    "RegisteredPoses",
    "SightRays",
    "TrackingSettings",
]
