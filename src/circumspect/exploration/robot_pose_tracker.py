"""Where the robot is between two frames."""

from __future__ import annotations

from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.geometry.composition import composed
from circumspect.robot import Velocity, arc
from circumspect.sensing import Odometry
from circumspect.tracking import PoseEstimate


class Whereabouts:
    """The pose of the latest frame, carried on by odometry, or else by what was commanded."""

    def __init__(self, T_base_camera: RigidTransform) -> None:
        """Start at the origin of the map.

        Args:
            T_base_camera: Where the camera is mounted.
        """
        self._T_camera_base = T_base_camera.inv()
        self._T_map_base = PlanarPose()
        self._T_odom_base: PlanarPose | None = None
        self._commanded = PlanarPose()

    def corrected(self, pose: PoseEstimate, odometry: Odometry | None) -> None:
        """Take the pose of a frame and what the wheels said at its time."""
        self._T_map_base = PlanarPose.from_transform(
            composed(pose.T_map_camera, self._T_camera_base)
        )
        self._T_odom_base = None if odometry is None else odometry.T_odom_base
        self._commanded = PlanarPose()

    def moved(self, velocity: Velocity, seconds: float) -> None:
        """Take what was commanded for some time."""
        length, turn = velocity.forward * seconds, velocity.turn * seconds
        self._commanded = self._commanded @ arc(length, turn)

    def T_map_base(self, odometry: Odometry | None) -> PlanarPose:
        """Where the base is now."""
        if odometry is None:
            return self._T_map_base @ self._commanded
        if self._T_odom_base is None:
            # The wheels say something again, or for the first time: from here on they count.
            self._T_map_base = self._T_map_base @ self._commanded
            self._T_odom_base = odometry.T_odom_base
            self._commanded = PlanarPose()
        return self._T_map_base @ self._T_odom_base.inverse() @ odometry.T_odom_base
