"""The pose of the robot between two frames."""

from __future__ import annotations

from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.geometry.composition import composed
from circumspect.robot import Velocity, arc
from circumspect.sensing import Odometry
from circumspect.tracking import PoseEstimate


class RobotPoseTracker:
    """Extends the pose of the latest frame by odometry, or else by the commanded motion."""

    def __init__(self, T_base_camera: RigidTransform) -> None:
        """Start at the origin of the map.

        Args:
            T_base_camera: Mount of the camera.
        """
        self._T_camera_base = T_base_camera.inv()
        self._T_map_base = PlanarPose()
        self._T_odom_base: PlanarPose | None = None
        self._commanded = PlanarPose()

    def set_pose(self, pose: PoseEstimate, odometry: Odometry | None) -> None:
        """Set the pose of a frame, and the odometry at its time."""
        self._T_map_base = PlanarPose.from_transform(
            composed(pose.T_map_camera, self._T_camera_base)
        )
        self._T_odom_base = None if odometry is None else odometry.T_odom_base
        self._commanded = PlanarPose()

    def add_command(self, velocity: Velocity, seconds: float) -> None:
        """Add a velocity that was commanded for some time."""
        length, turn = velocity.forward * seconds, velocity.turn * seconds
        self._commanded = self._commanded @ arc(length, turn)

    def T_map_base(self, odometry: Odometry | None) -> PlanarPose:
        """The current pose of the base."""
        if odometry is None:
            return self._T_map_base @ self._commanded
        if self._T_odom_base is None:
            # The odometry begins, or begins again.
            self._T_map_base = self._T_map_base @ self._commanded
            self._T_odom_base = odometry.T_odom_base
            self._commanded = PlanarPose()
        return self._T_map_base @ self._T_odom_base.inverse() @ odometry.T_odom_base
