"""Log of the path of a scan."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.exploration.object_scan import ObjectScan
from circumspect.exploration.view_record import ViewOutcome
from circumspect.geometry import Trajectory, TrajectoryLog
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.runs.run_folder import RunFolder
from circumspect.runs.run_path import RunPath


class RunPathLog:
    """Logs odometry, distance and views of a scan; a `PipelineObserver`.

    List this observer before the run's folder, which draws the path.
    """

    def __init__(
        self,
        scan: ObjectScan,
        folder: RunFolder | None = None,
        truth: Callable[[], Trajectory | None] | None = None,
        walls_xy: tuple[NDArray[np.float64], ...] = (),
    ) -> None:
        """Start with an empty log.

        Args:
            scan: The observed scan.
            folder: Gets the path when the run ends.
            truth: Returns the camera's true trajectory when the run ends, world frame.
            walls_xy: Outlines of walls and clutter, world frame [m]; shown only with the truth,
                which aligns map and world.
        """
        self._scan = scan
        self._folder = folder
        self._truth = truth
        self._walls_xy = walls_xy
        self._stamps: list[float] = []
        self._driven: list[float] = []
        self._wheels = TrajectoryLog()

    @property
    def odometry(self) -> Trajectory | None:
        """Path of the camera by odometry alone, odom frame; None without odometry."""
        return self._wheels.trajectory

    def on_step(self, step: RecognitionStep) -> None:
        """Log distance and odometry of the step's frame."""
        frame = self._scan.frame
        if not self._stamps or step.stamp > self._stamps[-1]:
            self._stamps.append(step.stamp)
            self._driven.append(self._scan.driven_m)
        if frame is not None and (T_odom_camera := frame.T_odom_camera) is not None:
            self._wheels.add(frame.stamp, T_odom_camera)

    def on_end(self, result: RecognitionResult) -> None:
        """Pass the path to the folder."""
        if self._folder is not None:
            self._folder.run_path = self.run_path(result)

    def run_path(self, result: RecognitionResult) -> RunPath:
        """The path in the map frame of the result.

        Args:
            result: The run; its poses align odom and world frame with the map.
        """
        wheels, world = self.odometry, self._truth() if self._truth is not None else None
        T_map_odom, T_map_world = _first_offset(wheels, result), _first_offset(world, result)
        odometry = truth = None
        walls: tuple[NDArray[np.float64], ...] = ()
        if wheels is not None and T_map_odom is not None:
            odometry = wheels.moved(T_map_odom)
        if world is not None and T_map_world is not None:
            truth = world.moved(T_map_world)
            walls = tuple(_transformed(T_map_world, line) for line in self._walls_xy)
        return RunPath(
            stamps=np.array(self._stamps),
            driven_m=np.array(self._driven),
            odometry=odometry,
            truth=truth,
            views=tuple(
                record.view for record in self._scan.views if record.outcome == ViewOutcome.REACHED
            ),
            missed=tuple(
                record.view for record in self._scan.views if record.outcome != ViewOutcome.REACHED
            ),
            walls_xy=walls,
        )


def _first_offset(
    trajectory: Trajectory | None, result: RecognitionResult
) -> RigidTransform | None:
    """Transform that aligns a trajectory with the run at the first frame with a pose in both.

    The odometry may begin later than the run.
    """
    if trajectory is None:
        return None
    numbers = {stamp: number for number, stamp in enumerate(trajectory.stamps.tolist())}
    for step in result.steps:
        if step.pose is not None and step.stamp in numbers:
            there = trajectory.T_map_camera[numbers[step.stamp]]
            return step.pose.T_map_camera * there.inv()
    return None


def _transformed(T_map_world: RigidTransform, line_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    points = np.column_stack([line_xy, np.zeros(len(line_xy))])
    return T_map_world.apply(points)[:, :2]
