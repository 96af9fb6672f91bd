"""What is known when the robot asks where to look from next."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.planning.answer import Answer
from circumspect.planning.next_view import NextView
from circumspect.planning.plan_view import centre_of

NOTHING_XY = np.empty((0, 2))


@dataclass(frozen=True, eq=False)
class Situation:
    """The object so far, the robot, and what was tried.

    Attributes:
        points_xyz: (n, 3) [m] surface of the object so far, map frame.
        normals_xyz: (n, 3) unit normals of those points.
        footprint_xy: (c, 2) [m] plan-view cells in which the object has points; see `footprint`.
        T_map_base: Where the robot is.
        T_base_camera: Where its camera is mounted (optical frame).
        camera: Says what fits its image.
        depth_range: The nearest and the farthest depth that the camera measures [m].
        obstacles_xy: (m, 2) [m] everything else that stands in the way, map frame.
        robot_radius: Of the circle round `base_link` that holds the robot [m].
        visited: Where the robot was, in order; the last one is near `T_map_base`.
        unreachable: Views that could not be reached, since the last one that was.
        given_up: All views that could not be reached.
        answers: Those so far, one a frame that showed the object.
    """

    points_xyz: NDArray[np.float64]
    normals_xyz: NDArray[np.float64]
    footprint_xy: NDArray[np.float64]
    T_map_base: PlanarPose
    T_base_camera: RigidTransform
    camera: PinholeCamera
    depth_range: tuple[float, float]
    obstacles_xy: NDArray[np.float64] = field(default_factory=lambda: NOTHING_XY)
    robot_radius: float = 0.3
    visited: tuple[PlanarPose, ...] = ()
    unreachable: tuple[NextView, ...] = ()
    given_up: tuple[NextView, ...] = ()
    answers: tuple[Answer, ...] = ()

    @cached_property
    def centre_xy(self) -> NDArray[np.float64]:
        """(2,) [m] the middle of what is known of the object."""
        return centre_of(self.points_xyz)
