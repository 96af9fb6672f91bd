"""Where the camera was during a run."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import Trajectory
from circumspect.pipeline.records import RecognitionResult


def camera_path(result: RecognitionResult) -> Trajectory | None:
    """Poses of the frames in the order of time; None where no frame has one.

    A frame that came late, or twice, is left out.
    """
    return increasing(
        (step.stamp, step.pose.T_map_camera) for step in result.steps if step.pose is not None
    )


def increasing(poses: Iterable[tuple[float, RigidTransform]]) -> Trajectory | None:
    """A trajectory of those whose stamp is later than all before; None of none."""
    kept: list[tuple[float, RigidTransform]] = []
    for stamp, pose in poses:
        if not kept or stamp > kept[-1][0]:
            kept.append((stamp, pose))
    if not kept:
        return None
    stamps = np.array([stamp for stamp, _ in kept])
    return Trajectory(stamps, RigidTransform.concatenate([pose for _, pose in kept]))
