"""Files and figures of runs: run folder, playback, picture."""

from circumspect.runs.run_folder import RunFolder
from circumspect.runs.run_path import PlannedView, RunPath, camera_path

__all__ = ["PlannedView", "RunFolder", "RunPath", "camera_path"]
