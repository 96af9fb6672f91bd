"""The path of the camera in a run."""

from __future__ import annotations

from circumspect.geometry import Trajectory, TrajectoryLog
from circumspect.recognition import RecognitionResult


def camera_path(result: RecognitionResult) -> Trajectory | None:
    """Poses of the frames in the order of time; None if no frame has one.

    Frames out of order, and repeated ones, are skipped.
    """
    log = TrajectoryLog()
    for step in result.steps:
        if step.pose is not None:
            log.add(step.stamp, step.pose.T_map_camera)
    return log.trajectory
