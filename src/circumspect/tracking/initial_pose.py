"""The pose of the first frame of a map."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import se3_matrices
from circumspect.geometry.composition import between, composed
from circumspect.motion import MotionSettings, PoseWithCovariance
from circumspect.sensing import RgbdFrame

MAX_DISTANCE_M = 5e4
"""Largest coordinate of the first pose [m]; voxel indices overflow beyond it."""
INITIAL_SIGMA = 1e-4
"""Standard deviation of the first pose in all directions [rad, m]: it defines the map frame."""


class InitialPose:
    """Finds the pose of the first frame of the map.

    A given pose belongs to the very first frame. Odometry propagates it over frames that do not
    start a map.
    """

    def __init__(self, T_map_camera: RigidTransform | None) -> None:
        """Set the given pose.

        Args:
            T_map_camera: Pose of the first frame; None if it is not given.
        """
        self._T_map_camera = T_map_camera
        self._T_odom_camera: RigidTransform | None = None

    def skip(self, frame: RgbdFrame) -> None:
        """Propagate the pose over a frame that does not start a map."""
        before, now = self._T_odom_camera, frame.T_odom_camera
        if self._T_map_camera is not None and before is not None and now is not None:
            self._T_map_camera = composed(self._T_map_camera, between(before, now))
        if now is not None:
            self._T_odom_camera = now

    def at(self, frame: RgbdFrame, motion: MotionSettings) -> PoseWithCovariance:
        """The pose of the next frame.

        The first available of: the given pose, odometry and mount, the pose of the frame, the
        mount.

        Args:
            frame: The frame.
            motion: Uncertainty of roll, pitch and height of the robot.

        Raises:
            InputError: The frame has neither a pose nor a mount, or is too far from the origin.
        """
        self.skip(frame)
        T, mount = self._T_map_camera, frame.T_base_camera
        for alternative in (frame.T_odom_camera, frame.T_map_camera, mount):
            T = alternative if T is None else T
        if T is None:
            raise InputError(
                f"the frame at {frame.stamp:.3f} s has neither a pose nor a robot under it; "
                "registration needs the pose of the first frame"
            )
        if (distance := float(np.abs(T.translation).max())) > MAX_DISTANCE_M:
            raise InputError(
                f"the frame at {frame.stamp:.3f} s was taken {distance / 1e3:.0f} km from the "
                "origin; subtract the position of the first pose from all poses"
            )
        covariance = np.eye(6) * INITIAL_SIGMA**2
        if mount is not None:
            # Position and heading define the map; roll, pitch and height depend on bumps.
            level = np.zeros((6, 6))
            level[np.ix_((0, 1, 5), (0, 1, 5))] = motion.level_covariance
            Ad = se3_matrices.adjoint(se3_matrices.inverse(mount.as_matrix()))
            covariance = covariance + Ad @ level @ Ad.T
        return PoseWithCovariance(T.as_matrix(), covariance)
