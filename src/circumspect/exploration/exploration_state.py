"""What a scan has learnt so far: what its planner and its driving go by."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.exploration.obstacle_map import ObstacleMap
from circumspect.exploration.robot_pose_tracker import Whereabouts
from circumspect.geometry import PlanarPose
from circumspect.planning import Answer, NextView, Situation, footprint
from circumspect.recognition.recognition_step import CLASSIFIED, RecognitionStep
from circumspect.reconstruction import ObjectModel
from circumspect.robot import MobileRobot
from circumspect.sensing import RgbdFrame

BUMP_XY = np.array([[0.3, side] for side in (-0.2, -0.1, 0.0, 0.1, 0.2)])
"""What a blocked robot takes to be in its way, in its own frame [m]."""
STRIDE = 0.02
"""Places nearer than this to the last one are not kept [m]."""


class ScanKnowledge:
    """Where the robot is and was, what stands about, and the answers so far.

    Attributes:
        whereabouts: Where the robot is.
        frames: How many frames went through the pipeline.
        in_view: Whether the latest one showed the object.
        reliable: Whether the pose of the latest one is reliable.
        unreachable: Views that could not be reached, since the last one that was.
    """

    def __init__(self, robot: MobileRobot) -> None:
        """Know nothing but the robot."""
        self._robot = robot
        self.whereabouts = Whereabouts(robot.T_base_camera)
        self.frames = 0
        self.in_view = self.reliable = False
        self._reliable_at = self._clock
        self._doubtful = False
        self.unreachable: list[NextView] = []
        self._given_up: list[NextView] = []
        self._visited: list[PlanarPose] = []
        self._answers: list[Answer] = []
        self._obstacles = ObstacleMap()
        self._bumps_xy = np.empty((0, 2))
        self._told: tuple[tuple[object, ...], Situation] | None = None

    @property
    def T_map_base(self) -> PlanarPose:
        """Where the robot is now."""
        return self.whereabouts.T_map_base(self._robot.odometry())

    @property
    def doubted_for(self) -> float:
        """Time without a reliable pose, if the latest frame had depth [s]."""
        return self._clock - self._reliable_at if self._doubtful else 0.0

    @property
    def blind_for(self) -> float:
        """Time without a reliable pose for whatever reason [s]."""
        return self._clock - self._reliable_at

    @property
    def _clock(self) -> float:
        """Stands still while somebody holds the robot [s]."""
        return self._robot.now - self._robot.held

    def heard(self, step: RecognitionStep, frame: RgbdFrame) -> None:
        """Take what a frame led to."""
        self.frames += 1
        self.in_view = step.outcome == CLASSIFIED
        self.reliable = step.pose is not None and step.pose.reliable
        if step.pose is not None:
            odometry = None if step.odometry_warning else frame.odometry
            self.whereabouts.corrected(step.pose, odometry)
            self._doubtful = not self.reliable
            if self.reliable:
                self._reliable_at = self._clock
                self._obstacles = self._obstacles.with_frame(frame, step.pose.T_map_camera)
        if self.in_view and (answer := step.answer) is not None:
            self._visit()
            self._answers.append(answer)

    def _visit(self) -> None:
        here = self.T_map_base
        if not self._visited or np.linalg.norm(here.xy - self._visited[-1].xy) >= STRIDE:
            self._visited.append(here)

    def bumped(self) -> None:
        """Remember that something is before the robot that the camera did not see."""
        self._bumps_xy = np.vstack([self._bumps_xy, self.T_map_base.applied(BUMP_XY)])

    def give_up(self, view: NextView) -> None:
        """Remember that a view can not be reached."""
        self.unreachable.append(view)
        self._given_up.append(view)

    def situation(self, model: ObjectModel) -> Situation:
        """All of it, as a planner wants it; the same one as long as nothing changes.

        Args:
            model: The object so far.
        """
        here = self.T_map_base
        state = (
            model, self._obstacles, here, self.frames, len(self._bumps_xy), len(self._given_up),
            len(self.unreachable),
        )  # fmt: skip
        if self._told is None or state != self._told[0]:
            self._told = state, self._situation(model, here)
        return self._told[1]

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
    """(n, 3) points and normals; none while nothing is known of the object."""
    try:
        cloud = model.cloud()
    except GeometryError:
        return np.empty((0, 3)), np.empty((0, 3))
    points, normals = cloud.points_xyz, cloud.normals_xyz
    return points, np.zeros_like(points) if normals is None else normals
