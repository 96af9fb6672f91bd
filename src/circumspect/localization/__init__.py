"""The intelligent space: fixed cameras that see a tag on the robot and say where it is."""

from circumspect.localization.ceiling_image import CeilingImage
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.lens_camera import LensCamera
from circumspect.localization.tag_detector import TagDetection, TagDetector
from circumspect.localization.tag_mount import TagMount
from circumspect.localization.tag_pose import TagPose, tag_pose

__all__ = [
    "CeilingImage",
    "FixedCamera",
    "LensCamera",
    "TagDetection",
    "TagDetector",
    "TagMount",
    "TagPose",
    "tag_pose",
]
