"""Input and output of view planners."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.planning.plan_view import centre_of

NO_PLACES_XY = np.empty((0, 2))


@dataclass(frozen=True, slots=True)
class Answer:
    """A prediction during a run.

    Attributes:
        probabilities: Class to probability.
        coverage: Fraction of the azimuth seen so far, 0 … 1.
        in_distribution: Whether the object resembles the trained classes.
        confident: Whether the answer may be acted on, by the classifier's rule.
    """

    probabilities: Mapping[str, float]
    coverage: float
    in_distribution: bool = True
    confident: bool = False

    @property
    def label(self) -> str:
        """The most probable class."""
        return max(self.probabilities, key=lambda name: self.probabilities[name])


@dataclass(frozen=True)
class NextView:
    """The next view.

    Attributes:
        T_map_base: Pose of the robot.
        looks_at_xy: Point on the object that the camera faces [m].
        normal_xy: Outward unit normal of the surface there; None if the planner used none.
        reason: Why the view was chosen.
    """

    T_map_base: PlanarPose
    looks_at_xy: tuple[float, float]
    normal_xy: tuple[float, float] | None
    reason: str


@dataclass(frozen=True)
class Finished:
    """No further view is needed or possible.

    Attributes:
        reason: Why the planner finished.
    """

    reason: str


@dataclass(frozen=True, eq=False)
class PlannerInput:
    """Object, robot, obstacles and failed views.

    Attributes:
        points_xyz: (n, 3) [m] surface of the object so far, map frame.
        normals_xyz: (n, 3) unit normals of those points.
        footprint_xy: (c, 2) [m] plan-view cells in which the object has points; see `footprint`.
        T_map_base: Pose of the robot.
        T_base_camera: Mount of the camera (optical frame).
        camera: Intrinsics of the camera.
        depth_range: Minimum and maximum depth of the camera [m].
        obstacles_xy: (m, 2) other obstacles [m], map frame.
        robot_radius: Radius of the robot's footprint around `base_link` [m].
        visited: Past poses of the robot, in order; the last one is near `T_map_base`.
        unreachable: Views that could not be reached since the last one that was.
        given_up: All views that could not be reached.
        answers: Predictions so far, one per frame that showed the object.
    """

    points_xyz: NDArray[np.float64]
    normals_xyz: NDArray[np.float64]
    footprint_xy: NDArray[np.float64]
    T_map_base: PlanarPose
    T_base_camera: RigidTransform
    camera: PinholeCamera
    depth_range: tuple[float, float]
    obstacles_xy: NDArray[np.float64] = field(default_factory=lambda: NO_PLACES_XY)
    robot_radius: float = 0.3
    visited: tuple[PlanarPose, ...] = ()
    unreachable: tuple[NextView, ...] = ()
    given_up: tuple[NextView, ...] = ()
    answers: tuple[Answer, ...] = ()

    @cached_property
    def centre_xy(self) -> NDArray[np.float64]:
        """(2,) centre of the known part of the object [m]."""
        return centre_of(self.points_xyz)
