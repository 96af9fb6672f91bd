"""Where the robot was, in bounded memory."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import between, composed
from circumspect.tracking import PoseEstimate, PoseEstimator

STRIDE, TURN = 0.02, float(np.radians(5.0))
"""Poses nearer than this to the last one are not kept [m, rad]."""
MOST = 500
"""When so many are kept, every second one of them is forgotten; all are told anew every second."""


class PathLog:
    """Poses of frames that could be placed, corrected as more is known."""

    def __init__(self) -> None:
        self._kept: list[tuple[float, PoseEstimate, RigidTransform]] = []

    def __len__(self) -> int:
        return len(self._kept)

    def heard(self, stamp: float, pose: PoseEstimate, T_base_camera: RigidTransform | None) -> None:
        """Take the pose of a frame.

        Args:
            stamp: Of the frame [s].
            pose: Where it was taken from.
            T_base_camera: Where the camera was mounted; None makes it a path of the camera.
        """
        if not pose.reliable:
            return
        if self._kept:
            moved = between(self._kept[-1][1].T_map_camera, pose.T_map_camera)
            step, turn = np.linalg.norm(moved.translation), moved.rotation.magnitude()
            if step < STRIDE and turn < TURN:
                return
        mount = RigidTransform.identity() if T_base_camera is None else T_base_camera
        self._kept.append((stamp, pose, mount.inv()))
        if len(self._kept) > MOST:
            del self._kept[1:-1:2]

    def path(self, poses: PoseEstimator) -> list[tuple[float, RigidTransform]]:
        """Stamps [s], and where the robot was by all that is known now.

        Args:
            poses: What gave the poses.
        """
        corrected = poses.corrected([estimate for _, estimate, _ in self._kept])
        return [
            (stamp, composed(T_map_camera, T_camera_base))
            for (stamp, _, T_camera_base), T_map_camera in zip(self._kept, corrected, strict=True)
        ]
