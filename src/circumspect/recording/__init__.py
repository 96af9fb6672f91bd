"""Recorded RGB-D frames: writing of ROS 2 bags, reading of many formats."""

from circumspect.recording.bag_recording import BagRecording, BagSettings
from circumspect.recording.ceiling_bag import CeilingBag
from circumspect.recording.frame_folder import FrameFolder
from circumspect.recording.open_recording import is_bag, open_bag, open_recording
from circumspect.recording.recording import Recording
from circumspect.recording.run_recorder import RecordingRobot, RunRecorder
from circumspect.recording.seven_scenes import SevenScenesFolder
from circumspect.recording.topic_choice import TopicNames
from circumspect.recording.tum_rgbd import TumRgbdFolder

__all__ = [
    "BagRecording",
    "BagSettings",
    "CeilingBag",
    "FrameFolder",
    "Recording",
    "RecordingRobot",
    "RunRecorder",
    "SevenScenesFolder",
    "TopicNames",
    "TumRgbdFolder",
    "is_bag",
    "open_bag",
    "open_recording",
]
