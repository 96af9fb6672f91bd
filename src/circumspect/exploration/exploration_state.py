"""The state of a scan, for planning and driving."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import GeometryError
from circumspect.exploration.obstacle_map import ObstacleMap
from circumspect.geometry import PlanarPose
from circumspect.geometry.composition import composed
from circumspect.planning import Answer, NextView, PlannerInput, footprint
from circumspect.recognition import FrameOutcome, RecognitionStep
from circumspect.reconstruction import ObjectModel
from circumspect.robot import MobileRobot, Velocity, arc
from circumspect.sensing import Odometry, RgbdFrame
from circumspect.tracking import PoseEstimate

BUMP_XY = np.array([[0.3, side] for side in (-0.2, -0.1, 0.0, 0.1, 0.2)])
"""(5, 2) [m] the obstacle that a blocked robot adds, base frame."""
MIN_STEP_M = 0.02
"""Minimum distance between recorded visited poses [m]."""


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
        """Add a velocity and its duration [s]."""
        length, turn = velocity.forward * seconds, velocity.turn * seconds
        self._commanded = self._commanded @ arc(length, turn)

    def T_map_base(self, odometry: Odometry | None) -> PlanarPose:
        """The current pose of the base."""
        if odometry is None:
            return self._T_map_base @ self._commanded
        if self._T_odom_base is None:
            # The odometry starts or restarts.
            self._T_map_base = self._T_map_base @ self._commanded
            self._T_odom_base = odometry.T_odom_base
            self._commanded = PlanarPose()
        return self._T_map_base @ self._T_odom_base.inverse() @ odometry.T_odom_base


class ExplorationState:
    """The robot's pose and path, the obstacles, and the answers so far.

    Attributes:
        pose_tracker: The current pose of the robot.
        frames: Number of processed frames.
        in_view: Whether the latest frame showed the object.
        reliable: Whether the pose of the latest frame is reliable.
        motion_is_known: Whether scans or odometry measure the motion of the robot.
        unreachable: Views that could not be reached, since the last reached one.
    """

    def __init__(self, robot: MobileRobot) -> None:
        """Start with an empty map."""
        self._robot = robot
        self.pose_tracker = RobotPoseTracker(robot.T_base_camera)
        self.frames = 0
        self.in_view = self.reliable = self.motion_is_known = False
        self._reliable_at = self._clock
        self._is_doubted = False
        self.unreachable: list[NextView] = []
        self._given_up: list[NextView] = []
        self._visited: list[PlanarPose] = []
        self._answers: list[Answer] = []
        self._obstacles = ObstacleMap()
        self._bumps_xy = np.empty((0, 2))
        self._latest: tuple[tuple[object, ...], PlannerInput] | None = None

    @property
    def T_map_base(self) -> PlanarPose:
        """The current pose of the robot."""
        return self.pose_tracker.T_map_base(self._robot.odometry())

    @property
    def doubted_for(self) -> float:
        """Time without a reliable pose, if the latest one is contradicted or ambiguous [s]."""
        return self._clock - self._reliable_at if self._is_doubted else 0.0

    @property
    def blind_for(self) -> float:
        """Time without a reliable pose for any reason [s]."""
        return self._clock - self._reliable_at

    @property
    def _clock(self) -> float:
        """Time without the pauses of the operator [s]."""
        return self._robot.now - self._robot.paused_seconds

    def update(self, step: RecognitionStep, frame: RgbdFrame) -> None:
        """Add the result of a frame."""
        self.frames += 1
        self.in_view = step.outcome is FrameOutcome.CLASSIFIED
        self.reliable = step.pose is not None and step.pose.reliable
        if step.pose is not None:
            odometry = None if step.odometry_warning else frame.odometry
            self.pose_tracker.set_pose(step.pose, odometry)
            self.motion_is_known = self.reliable or odometry is not None
            self._is_doubted = not (self.reliable or step.pose.unverified)
            if self.reliable:
                self._reliable_at = self._clock
                self._obstacles = self._obstacles.with_frame(frame, step.pose.T_map_camera)
        if self.in_view and (answer := step.answer) is not None:
            self._visit()
            self._answers.append(answer)

    def _visit(self) -> None:
        here = self.T_map_base
        if not self._visited or np.linalg.norm(here.xy - self._visited[-1].xy) >= MIN_STEP_M:
            self._visited.append(here)

    def add_bump(self) -> None:
        """Add an obstacle in front of the robot that the camera did not observe."""
        self._bumps_xy = np.vstack([self._bumps_xy, self.T_map_base.applied(BUMP_XY)])

    def give_up(self, view: NextView) -> None:
        """Record that a view cannot be reached."""
        self.unreachable.append(view)
        self._given_up.append(view)

    def planner_input(self, model: ObjectModel) -> PlannerInput:
        """The input of a planner; the same instance while nothing changes.

        Args:
            model: The object so far.
        """
        here = self.T_map_base
        state = (
            model, self._obstacles, here, self.frames, len(self._bumps_xy), len(self._given_up),
            len(self.unreachable),
        )  # fmt: skip
        if self._latest is None or state != self._latest[0]:
            self._latest = state, self._planner_input(model, here)
        return self._latest[1]

    def _planner_input(self, model: ObjectModel, here: PlanarPose) -> PlannerInput:
        preview = model.preview
        points, normals = _surface(preview)
        flat = footprint(points, preview.voxel or 0.0)
        obstacles = self._obstacles.places_xy(flat)
        return PlannerInput(
            points_xyz=points,
            normals_xyz=normals,
            footprint_xy=flat,
            T_map_base=here,
            T_base_camera=self._robot.T_base_camera,
            camera=self._robot.camera.intrinsics,
            depth_range=self._robot.camera.depth_range,
            obstacles_xy=np.vstack([obstacles, self._bumps_xy]),
            robot_radius=self._robot.radius,
            visited=tuple(self._visited),
            unreachable=tuple(self.unreachable),
            given_up=tuple(self._given_up),
            answers=tuple(self._answers),
        )


def _surface(model: ObjectModel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, 3) points [m] and (n, 3) normals; empty before the first points."""
    try:
        cloud = model.cloud()
    except GeometryError:
        return np.empty((0, 3)), np.empty((0, 3))
    points, normals = cloud.points_xyz, cloud.normals_xyz
    return points, np.zeros_like(points) if normals is None else normals
