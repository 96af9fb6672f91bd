"""The state of a scan: the basis of planning and driving."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.exploration.obstacle_map import ObstacleMap
from circumspect.exploration.robot_pose_tracker import RobotPoseTracker
from circumspect.geometry import PlanarPose
from circumspect.planning import Answer, NextView, Situation, footprint
from circumspect.recognition import FrameOutcome, RecognitionStep
from circumspect.reconstruction import ObjectModel
from circumspect.robot import MobileRobot
from circumspect.sensing import RgbdFrame

BUMP_XY = np.array([[0.3, side] for side in (-0.2, -0.1, 0.0, 0.1, 0.2)])
"""(5, 2) [m] the obstacle that a blocked robot adds, base frame."""
MIN_STEP_M = 0.02
"""Visited poses nearer than this to the last one are not kept."""


class ExplorationState:
    """The robot's pose and path, the obstacles, and the answers so far.

    Attributes:
        pose_tracker: The current pose of the robot.
        frames: Number of processed frames.
        in_view: Whether the latest frame showed the object.
        reliable: Whether the pose of the latest frame is reliable.
        unreachable: Views that could not be reached, since the last one that was.
    """

    def __init__(self, robot: MobileRobot) -> None:
        """Start with an empty map."""
        self._robot = robot
        self.pose_tracker = RobotPoseTracker(robot.T_base_camera)
        self.frames = 0
        self.in_view = self.reliable = False
        self._reliable_at = self._clock
        self._is_unreliable = False
        self.unreachable: list[NextView] = []
        self._given_up: list[NextView] = []
        self._visited: list[PlanarPose] = []
        self._answers: list[Answer] = []
        self._obstacles = ObstacleMap()
        self._bumps_xy = np.empty((0, 2))
        self._latest: tuple[tuple[object, ...], Situation] | None = None

    @property
    def T_map_base(self) -> PlanarPose:
        """The current pose of the robot."""
        return self.pose_tracker.T_map_base(self._robot.odometry())

    @property
    def doubted_for(self) -> float:
        """Time without a reliable pose, if the latest frame had depth [s]."""
        return self._clock - self._reliable_at if self._is_unreliable else 0.0

    @property
    def blind_for(self) -> float:
        """Time without a reliable pose for whatever reason [s]."""
        return self._clock - self._reliable_at

    @property
    def _clock(self) -> float:
        """Stands still while somebody holds the robot [s]."""
        return self._robot.now - self._robot.held

    def update(self, step: RecognitionStep, frame: RgbdFrame) -> None:
        """Add the result of a frame."""
        self.frames += 1
        self.in_view = step.outcome is FrameOutcome.CLASSIFIED
        self.reliable = step.pose is not None and step.pose.reliable
        if step.pose is not None:
            odometry = None if step.odometry_warning else frame.odometry
            self.pose_tracker.set_pose(step.pose, odometry)
            self._is_unreliable = not self.reliable
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
        """Add an obstacle in front of the robot that the camera did not see."""
        self._bumps_xy = np.vstack([self._bumps_xy, self.T_map_base.applied(BUMP_XY)])

    def give_up(self, view: NextView) -> None:
        """Record that a view cannot be reached."""
        self.unreachable.append(view)
        self._given_up.append(view)

    def situation(self, model: ObjectModel) -> Situation:
        """The input of a planner; the same object as long as nothing changes.

        Args:
            model: The object so far.
        """
        here = self.T_map_base
        state = (
            model, self._obstacles, here, self.frames, len(self._bumps_xy), len(self._given_up),
            len(self.unreachable),
        )  # fmt: skip
        if self._latest is None or state != self._latest[0]:
            self._latest = state, self._situation(model, here)
        return self._latest[1]

    def _situation(self, model: ObjectModel, here: PlanarPose) -> Situation:
        preview = model.preview
        points, normals = _surface(preview)
        flat = footprint(points, preview.voxel or 0.0)
        obstacles = self._obstacles.places_xy(flat)
        return Situation(
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
    """(n, 3) points [m] and normals; empty before the first points."""
    try:
        cloud = model.cloud()
    except GeometryError:
        return np.empty((0, 3)), np.empty((0, 3))
    points, normals = cloud.points_xyz, cloud.normals_xyz
    return points, np.zeros_like(points) if normals is None else normals
