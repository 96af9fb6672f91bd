"""Where a robot that others drive should look from next."""

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
    Situation,
    SurfaceNormalPlanner,
    ViewPlanner,
    footprint,
)
from circumspect.recognition import RecognitionStep
from circumspect.sensing import RgbdFrame

STRIDE = 0.02
"""Places nearer than this to the last one are not kept [m]."""
MOST_PLACES, MOST_ANSWERS = 5000, 500


class NextViews:
    """Remembers where the robot was and what stands about, and asks a planner."""

    def __init__(
        self, depth_range: tuple[float, float], planner: ViewPlanner | None = None
    ) -> None:
        """Know nothing.

        Args:
            depth_range: The nearest and the farthest depth that the camera measures [m].
            planner: Chooses; None means the paper's rule.
        """
        self._depth_range = depth_range
        self._planner = planner or SurfaceNormalPlanner()
        self._visited: deque[PlanarPose] = deque(maxlen=MOST_PLACES)
        self._answers: deque[Answer] = deque(maxlen=MOST_ANSWERS)
        self._obstacles = ObstacleMap()

    def heard(self, step: RecognitionStep, frame: RgbdFrame) -> None:
        """Take what a frame led to."""
        if step.pose is None or not step.pose.reliable:
            return
        self._obstacles = self._obstacles.with_frame(frame, step.pose.T_map_camera)
        here = step.pose.T_map_base
        if here is not None and (
            not self._visited or np.linalg.norm(here.xy - self._visited[-1].xy) >= STRIDE
        ):
            self._visited.append(here)
        if (answer := step.answer) is not None:
            self._answers.append(answer)

    def advice(self, step: RecognitionStep, frame: RgbdFrame) -> NextView | Finished | None:
        """The next view; None while the robot's own place is not known.

        Args:
            step: The latest one.
            frame: Its frame.
        """
        mount, pose = frame.T_base_camera, step.pose
        if mount is None or pose is None or pose.T_map_base is None or not pose.reliable:
            return None
        situation = self._situation(step, frame, mount, pose.T_map_base)
        return None if situation is None else self._planner.next_view(situation)

    def _situation(
        self,
        step: RecognitionStep,
        frame: RgbdFrame,
        T_base_camera: RigidTransform,
        T_map_base: PlanarPose,
    ) -> Situation | None:
        preview = step.model.preview
        try:
            cloud = preview.cloud()
        except GeometryError:
            return None
        points, normals = cloud.points_xyz, cloud.normals_xyz
        flat = footprint(points, preview.voxel or 0.0)
        return Situation(
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
