"""Next-view recommendations for a robot that is driven by others."""

from __future__ import annotations

from collections import deque

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import GeometryError
from circumspect.exploration.obstacle_map import ObstacleMap
from circumspect.geometry import PlanarPose
from circumspect.planning import (
    Answer,
    Finished,
    NextView,
    PlannerInput,
    SurfaceNormalPlanner,
    ViewPlanner,
    footprint,
)
from circumspect.recognition import RecognitionStep
from circumspect.sensing import RgbdFrame

MIN_STEP_M = 0.02
"""Minimum distance between two remembered poses [m]."""
MAX_POSES, MAX_ANSWERS = 5000, 500


class NextViews:
    """Records poses and obstacles of the robot and queries a planner."""

    def __init__(
        self, depth_range: tuple[float, float], planner: ViewPlanner | None = None
    ) -> None:
        """Start without history.

        Args:
            depth_range: Minimum and maximum depth of the camera [m].
            planner: View planner; None for the paper's rule.
        """
        self._depth_range = depth_range
        self._planner = planner or SurfaceNormalPlanner()
        self._visited: deque[PlanarPose] = deque(maxlen=MAX_POSES)
        self._answers: deque[Answer] = deque(maxlen=MAX_ANSWERS)
        self._obstacles = ObstacleMap()

    def update(self, step: RecognitionStep, frame: RgbdFrame) -> None:
        """Record the result of a frame."""
        if step.pose is None or not step.pose.reliable:
            return
        self._obstacles = self._obstacles.with_frame(frame, step.pose.T_map_camera)
        here = step.pose.T_map_base
        if here is not None and (
            not self._visited or np.linalg.norm(here.xy - self._visited[-1].xy) >= MIN_STEP_M
        ):
            self._visited.append(here)
        if (answer := step.answer) is not None:
            self._answers.append(answer)

    def next_view(self, step: RecognitionStep, frame: RgbdFrame) -> NextView | Finished | None:
        """The recommended next view; None if the pose of the robot is unknown.

        Args:
            step: The latest step.
            frame: Its frame.
        """
        mount, pose = frame.T_base_camera, step.pose
        if mount is None or pose is None or pose.T_map_base is None or not pose.reliable:
            return None
        planner_input = self._planner_input(step, frame, mount, pose.T_map_base)
        return None if planner_input is None else self._planner.next_view(planner_input)

    def _planner_input(
        self,
        step: RecognitionStep,
        frame: RgbdFrame,
        T_base_camera: RigidTransform,
        T_map_base: PlanarPose,
    ) -> PlannerInput | None:
        preview = step.model.preview
        try:
            cloud = preview.cloud()
        except GeometryError:
            return None
        points, normals = cloud.points_xyz, cloud.normals_xyz
        flat = footprint(points, preview.voxel or 0.0)
        return PlannerInput(
            points_xyz=points,
            normals_xyz=np.zeros_like(points) if normals is None else normals,
            footprint_xy=flat,
            T_map_base=T_map_base,
            T_base_camera=T_base_camera,
            camera=frame.camera,
            depth_range=self._depth_range,
            obstacles_xy=self._obstacles.places_xy(flat),
            visited=tuple(self._visited),
            answers=tuple(self._answers),
        )
