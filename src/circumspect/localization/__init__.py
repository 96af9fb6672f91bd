"""The intelligent space: fixed cameras that see a tag on the robot and say where it is."""

from circumspect.localization.calibration_file import (
    Calibration,
    read_calibration,
    read_lenses,
    write_calibration,
)
from circumspect.localization.ceiling_image import CeilingImage
from circumspect.localization.charuco_board import CharucoBoard
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.fusion import agreeing, fused
from circumspect.localization.intelligent_space import IntelligentSpace
from circumspect.localization.lens_calibration import LensCalibration, calibrate_lens
from circumspect.localization.lens_camera import LensCamera
from circumspect.localization.motion_filter import MotionFilter
from circumspect.localization.place_calibration import PlaceCalibration, calibrate_place
from circumspect.localization.sighting import Sighting
from circumspect.localization.slots import slots
from circumspect.localization.space_fix import BRIDGED, LOST, TRACKED, SpaceFix
from circumspect.localization.space_settings import SpaceSettings
from circumspect.localization.space_track import SpaceTrack
from circumspect.localization.space_tracker import SpaceTracker
from circumspect.localization.survey import Survey, SurveyedTag, read_survey, write_survey
from circumspect.localization.tag_detector import TagDetection, TagDetector
from circumspect.localization.tag_mount import TagMount
from circumspect.localization.tag_picture import tag_picture
from circumspect.localization.tag_pose import TagPose, tag_pose

__all__ = [
    "BRIDGED",
    "LOST",
    "TRACKED",
    "Calibration",
    "CeilingImage",
    "CharucoBoard",
    "FixedCamera",
    "IntelligentSpace",
    "LensCalibration",
    "LensCamera",
    "MotionFilter",
    "PlaceCalibration",
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
    "calibrate_lens",
    "calibrate_place",
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
