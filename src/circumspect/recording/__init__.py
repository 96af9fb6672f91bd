"""Recorded RGB-D frames."""

from circumspect.recording.frame_folder import FrameFolder, GivenPoses
from circumspect.recording.open_recording import open_recording
from circumspect.recording.seven_scenes import SevenScenesFolder
from circumspect.recording.tum_rgbd import TumRgbdFolder

__all__ = ["FrameFolder", "GivenPoses", "SevenScenesFolder", "TumRgbdFolder", "open_recording"]
