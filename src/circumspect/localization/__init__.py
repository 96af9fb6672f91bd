"""The intelligent space: ceiling cameras that localise the robot by a tag."""

from circumspect.localization.calibration_file import (
    Calibration,
    read_calibration,
    read_lenses,
    write_calibration,
)
from circumspect.localization.ceiling_image import CeilingImage, slots
from circumspect.localization.charuco_board import CharucoBoard
from circumspect.localization.extrinsics_calibration import (
    ExtrinsicsCalibration,
    calibrate_extrinsics,
)
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.fusion import agreeing, fused
from circumspect.localization.intelligent_space import IntelligentSpace
from circumspect.localization.lens_calibration import LensCalibration, calibrate_lens
from circumspect.localization.lens_camera import LensCamera
from circumspect.localization.motion_filter import MotionFilter
from circumspect.localization.space_fix import BRIDGED, LOST, TRACKED, Sighting, SpaceFix
from circumspect.localization.space_settings import SpaceSettings
from circumspect.localization.space_track import SpaceTrack
from circumspect.localization.space_tracker import SpaceTracker
from circumspect.localization.survey import Survey, SurveyedTag, read_survey, write_survey
from circumspect.localization.tag_detector import TagDetection, TagDetector
from circumspect.localization.tag_mount import TagMount, tag_picture
from circumspect.localization.tag_pose import TagPose, tag_pose

__all__ = [
    "BRIDGED",
    "LOST",
    "TRACKED",
    "Calibration",
    "CeilingImage",
    "CharucoBoard",
    "ExtrinsicsCalibration",
    "FixedCamera",
    "IntelligentSpace",
    "LensCalibration",
    "LensCamera",
    "MotionFilter",
    "Sighting",
    "SpaceFix",
    "SpaceSettings",
    "SpaceTrack",
    "SpaceTracker",
    "Survey",
    "SurveyedTag",
    "TagDetection",
    "TagDetector",
    "TagMount",
    "TagPose",
    "agreeing",
    "calibrate_extrinsics",
    "calibrate_lens",
    "fused",
    "read_calibration",
    "read_lenses",
    "read_survey",
    "slots",
    "tag_picture",
    "tag_pose",
    "write_calibration",
    "write_survey",
]
