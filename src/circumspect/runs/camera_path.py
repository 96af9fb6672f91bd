"""Where the camera was during a run."""

from __future__ import annotations

from circumspect.geometry import Trajectory, TrajectoryLog
from circumspect.recognition.recognition_step import RecognitionResult


def camera_path(result: RecognitionResult) -> Trajectory | None:
    """Poses of the frames in the order of time; None where no frame has one.

    A frame that came late, or twice, is left out.
    """
    log = TrajectoryLog()
    for step in result.steps:
        if step.pose is not None:
            log.add(step.stamp, step.pose.T_map_camera)
    return log.trajectory
