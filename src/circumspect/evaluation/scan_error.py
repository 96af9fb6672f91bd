"""Errors of a whole scan: trajectory, odometry alone, and shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import CircumspectError
from circumspect.evaluation.reconstruction_error import (
    ReconstructionError,
    reconstruction_error,
    visible_surface,
)
from circumspect.evaluation.trajectory_error import (
    Alignment,
    TrajectoryError,
    absolute_trajectory_error,
    alignment_between,
)
from circumspect.geometry import PinholeCamera, Trajectory
from circumspect.simulation import Scene

MAX_POSES = 120
"""True poses, evenly chosen, that determine what was visible."""


@dataclass(frozen=True)
class ScanError:
    """Errors of a scan by the simulator's ground truth; None where one is undefined.

    Attributes:
        trajectory: Error of the estimate, rigidly aligned.
        from_start: The same with the first poses aligned, as for a robot that trusts its start.
        odometry: Error of the wheel odometry alone, rigidly aligned.
        shape: Error of the model, placed by the mean difference of all poses.
        missing: Why an error is undefined.
    """

    trajectory: TrajectoryError | None = None
    from_start: TrajectoryError | None = None
    odometry: TrajectoryError | None = None
    shape: ReconstructionError | None = None
    missing: tuple[str, ...] = ()

    def summary(self) -> dict[str, float | None]:
        """The main errors as JSON types."""
        trajectory, odometry, shape = self.trajectory, self.odometry, self.shape
        return {
            "ate_rmse_m": None if trajectory is None else trajectory.rmse_m,
            "ate_odometry_rmse_m": None if odometry is None else odometry.rmse_m,
            "yaw_rmse_deg": None if trajectory is None else trajectory.yaw_rmse_deg,
            "yaw_odometry_rmse_deg": None if odometry is None else odometry.yaw_rmse_deg,
            "ate_from_start_rmse_m": None if self.from_start is None else self.from_start.rmse_m,
            "chamfer_m": None if shape is None else shape.chamfer_m,
            "accuracy_m": None if shape is None else shape.accuracy_m,
            "completion_m": None if shape is None else shape.completion_m,
            "completeness": None if shape is None else shape.completeness,
        }


def scan_error(
    truth: Trajectory,
    estimate: Trajectory | None,
    odometry: Trajectory | None,
    model_xyz: NDArray[np.float64] | None,
    scene: Scene,
    camera: PinholeCamera,
) -> ScanError:
    """Measure a scan; errors that are undefined do not affect the others.

    Args:
        truth: The camera's true poses at the frames, in the scene's frame.
        estimate: The estimated ones, in the robot's map frame.
        odometry: Those by odometry alone, in any frame.
        model_xyz: (n, 3) [m] the model's points, map frame; may be empty; None skips the
            comparison.
        scene: The simulated room, with the scanned object named "object".
        camera: The robot's camera.
    """
    missing: list[str] = []

    def compared(what: str, other: Trajectory | None, how: Alignment) -> TrajectoryError | None:
        if other is None:
            return None
        try:
            return absolute_trajectory_error(other, truth, how)
        except CircumspectError as error:
            missing.append(f"{what}: {error}")
            return None

    trajectory = compared("trajectory", estimate, Alignment.RIGID)
    from_start = compared("trajectory from its start", estimate, Alignment.FIRST_POSE)
    wheels = compared("odometry", odometry, Alignment.RIGID)
    shape = None
    if model_xyz is not None and not len(model_xyz):
        missing.append("shape: there is no object to compare")
    elif estimate is not None and model_xyz is not None:
        try:
            T_world_map = alignment_between(estimate, truth, Alignment.ORIENTATIONS)
            some = np.linspace(0, len(truth) - 1, min(len(truth), MAX_POSES)).astype(int)
            visible = visible_surface(scene, camera, truth.T_map_camera[some])
            mesh = next(surface.mesh for surface in scene.surfaces if surface.name == "object")
            shape = reconstruction_error(T_world_map.apply(model_xyz), mesh, visible)
        except CircumspectError as error:
            missing.append(f"shape: {error}")
    return ScanError(trajectory, from_start, wheels, shape, tuple(missing))
