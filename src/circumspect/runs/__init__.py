"""Runs on disk and in pictures: run folder, playback, figures."""

from circumspect.runs.camera_path import camera_path
from circumspect.runs.run_folder import RunFolder
from circumspect.runs.run_path import PlannedView, RunPath

__all__ = ["PlannedView", "RunFolder", "RunPath", "camera_path"]
