"""Where a map begins."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import se3
from circumspect.geometry.composition import between, composed
from circumspect.mapping.motion import Belief, MotionSettings
from circumspect.sensing import RgbdFrame

FARTHEST = 5e4
"""Of a map's begin from its origin [m]; from afar small_gicp can no longer count cells."""


class FirstPose:
    """The pose of the frame by which a map begins.

    A given one is that of the first frame; the wheels carry it on over frames that begin no map.
    """

    def __init__(self, T_map_camera: RigidTransform | None) -> None:
        """Begin.

        Args:
            T_map_camera: Of the first frame; None where nothing was given.
        """
        self._T_map_camera = T_map_camera
        self._T_odom_camera: RigidTransform | None = None

    def pass_over(self, frame: RgbdFrame) -> None:
        """Hear of a frame that begins no map."""
        before, now = self._T_odom_camera, frame.T_odom_camera
        if self._T_map_camera is not None and before is not None and now is not None:
            self._T_map_camera = composed(self._T_map_camera, between(before, now))
        if now is not None:
            self._T_odom_camera = now

    def at(self, frame: RgbdFrame, motion: MotionSettings) -> Belief:
        """Where the next frame was taken from.

        Args:
            frame: The frame.
            motion: How far a robot stands from level.

        Raises:
            InputError: It has neither a pose nor a robot under it, or lies out of this world.
        """
        self.pass_over(frame)
        T, mount = self._T_map_camera, frame.T_base_camera
        # A robot whose wheels say nothing begins its map where it stands.
        for told in (frame.T_odom_camera, frame.T_map_camera, mount):
            T = told if T is None else T
        if T is None:
            raise InputError(
                f"the frame at {frame.stamp:.3f} s has neither a pose nor a robot under it; "
                "registration needs the pose of the first frame"
            )
        if (away := float(np.abs(T.translation).max())) > FARTHEST:
            raise InputError(
                f"the frame at {frame.stamp:.3f} s was taken {away / 1e3:.0f} km from the origin; "
                "take the place of the first pose off all of them"
            )
        covariance = np.diag([1e-4] * 6) ** 2
        if mount is not None:
            # The map is laid by place and heading; how the robot stands on bumps is not known.
            turn, height = motion.bump_turn, motion.bump_height
            bumps = np.diag([turn, turn, 0.0, 0.0, 0.0, height]) ** 2
            covariance = covariance + se3.moved_covariance(mount.inv(), bumps)
        return Belief(T, covariance)
