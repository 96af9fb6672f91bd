"""Real frames with hidden poses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import Trajectory
from circumspect.recording import SevenScenesFolder
from circumspect.tracking import Tracker, TrackingState

FRAMES = 20


def test_real_frames_are_tracked_without_their_poses(data_folder: Path) -> None:
    from circumspect.evaluation.trajectory_error import (
        absolute_trajectory_error,
        relative_pose_error,
    )

    tracker, tracked, true = Tracker(), [], []
    for number, frame in enumerate(SevenScenesFolder(data_folder / "redkitchen")):
        if number == FRAMES:
            break
        true.append(frame)
        tracked.append(tracker.track(frame if number == 0 else replace(frame, T_map_camera=None)))
    assert {estimate.state for estimate in tracked} == {TrackingState.TRACKING}
    stamps = np.array([frame.stamp for frame in true])
    found = Trajectory(stamps, RigidTransform.concatenate([e.T_map_camera for e in tracked]))
    truth = Trajectory(stamps, RigidTransform.concatenate([frame.pose for frame in true]))
    assert absolute_trajectory_error(found, truth).rmse_m < 0.015
    assert relative_pose_error(found, truth).median_m < 0.005
