"""The paths of robot, camera and odometry in a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose, Trajectory, TrajectoryLog
from circumspect.geometry.composition import composed
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.sensing import RgbdFrame


class OdometryPath:
    """Path of the camera by odometry alone, from the first frame with pose and odometry on.

    Attributes:
        frames: Numbers of the frames with odometry.
        places_xyz: Positions of the camera at these frames [m], map frame.
    """

    def __init__(self) -> None:
        """Start empty."""
        self.frames: list[int] = []
        self.places_xyz: list[tuple[float, float, float]] = []
        self._T_map_odom: RigidTransform | None = None

    def add(self, step: RecognitionStep, frame: RgbdFrame | None) -> None:
        """Add a frame if it has odometry and a mount."""
        if frame is None or (T_odom_camera := frame.T_odom_camera) is None:
            return
        T_map_odom = self._T_map_odom
        if T_map_odom is None:
            if step.pose is None:
                return
            T_map_odom = self._T_map_odom = composed(step.pose.T_map_camera, T_odom_camera.inv())
        self.frames.append(step.index)
        x, y, z = composed(T_map_odom, T_odom_camera).translation.tolist()
        self.places_xyz.append((x, y, z))

    def truncate(self, kept: int) -> None:
        """Keep only the newest positions.

        Args:
            kept: Number of positions.
        """
        self.frames, self.places_xyz = self.frames[-kept:], self.places_xyz[-kept:]


class PlannedView(Protocol):
    """A view that a planner chose."""

    @property
    def T_map_base(self) -> PlanarPose:
        """Pose of the robot."""
        ...

    @property
    def looks_at_xy(self) -> tuple[float, float]:
        """The point on the surface that the camera faces [m], map frame."""
        ...

    @property
    def normal_xy(self) -> tuple[float, float] | None:
        """Unit normal of the surface at that point; None if the planner used none."""
        ...


@dataclass(frozen=True, eq=False)
class RunPath:
    """The path of a robot through a room, map frame.

    Attributes:
        stamps: (n,) [s] stamps of frames, ascending.
        driven_m: (n,) [m] distance driven at these stamps.
        odometry: Path of the camera by odometry alone, from the run's first pose on; None without
            odometry.
        truth: The true path of the camera; None if unknown.
        views: The reached views, in order.
        missed: The views that were not reached.
        walls_xy: Outlines of walls and clutter, each (k, 2) [m].
    """

    stamps: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    driven_m: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    odometry: Trajectory | None = None
    truth: Trajectory | None = None
    views: tuple[PlannedView, ...] = ()
    missed: tuple[PlannedView, ...] = ()
    walls_xy: tuple[NDArray[np.float64], ...] = ()

    def driven_by(self, stamps: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """(k,) [m] distances driven at given times [s]; None if they are unknown."""
        if len(self.stamps) == 0:
            return None
        return np.interp(stamps, self.stamps, self.driven_m)


def camera_path(result: RecognitionResult) -> Trajectory | None:
    """The path of the camera over the frames; None if no frame has a pose.

    Repeated frames and frames out of order are skipped.
    """
    log = TrajectoryLog()
    for step in result.steps:
        if step.pose is not None:
            log.add(step.stamp, step.pose.T_map_camera)
    return log.trajectory
