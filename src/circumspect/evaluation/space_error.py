"""Errors of the intelligent space, and of a run with the intelligent space as ground truth."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.evaluation.trajectory_error import (
    TOLERANCE,
    Alignment,
    TrajectoryError,
    absolute_trajectory_error,
    alignment_between,
)
from circumspect.geometry import Trajectory
from circumspect.localization import SpaceTrack


@dataclass(frozen=True)
class SpaceError:
    """Differences of fixes from the truth, without alignment; both are in map.

    Attributes:
        fixes: How many were compared.
        position_rmse_m, position_p95_m, position_max_m: Of the distances [m].
        yaw_rmse_deg, yaw_p95_deg, yaw_max_deg: Of the angles [degrees].
        nees: Normalised estimation error squared: 3 if the covariance is consistent, less if it is
            too large.
    """

    fixes: int
    position_rmse_m: float
    position_p95_m: float
    position_max_m: float
    yaw_rmse_deg: float
    yaw_p95_deg: float
    yaw_max_deg: float
    nees: float

    def to_dict(self) -> dict[str, Any]:
        """JSON types."""
        return asdict(self)


def space_error(track: SpaceTrack, truth: Trajectory, bridged: bool = False) -> SpaceError:
    """Compare with the true poses of the robot.

    Args:
        track: Fixes of the intelligent space.
        truth: Poses of `base_link` in map.
        bridged: Also compare fixes without a measurement.

    Raises:
        InputError: No fix has a true pose at its time.
    """
    errors, squares = [], []
    for fix in track.known(bridged):
        nearest = int(np.argmin(np.abs(truth.stamps - fix.stamp)))
        if abs(truth.stamps[nearest] - fix.stamp) > TOLERANCE or fix.T_map_base is None:
            continue
        error = _planar(fix.T_map_base.as_transform(), truth.T_map_camera[nearest])
        errors.append(error)
        squares.append(float(error @ np.linalg.solve(fix.covariance, error)))  # pyright: ignore
    if not errors:
        raise InputError("no fix of the intelligent space has a true pose of its time")
    table = np.array(errors)
    places = np.linalg.norm(table[:, :2], axis=1)
    yaws = np.abs(np.degrees(table[:, 2]))
    return SpaceError(len(table), *_figures(places), *_figures(yaws), float(np.mean(squares)))


def error_against_space(
    estimate: Trajectory,
    track: SpaceTrack,
    T_base_camera: RigidTransform,
    alignment: Alignment = Alignment.RIGID,
) -> TrajectoryError:
    """The trajectory error of a run with the intelligent space as the ground truth.

    Bridged fixes are left out. The tag determines a pose on the floor, so the camera's height and
    tilt are those of its mounting.

    Args:
        estimate: The camera's path as estimated by a run.
        track: Of the same robot.
        T_base_camera: Where its camera is mounted.
        alignment: How the estimate is moved first.

    Raises:
        InputError: Too few common stamps.
        GeometryError: As `absolute_trajectory_error`.
    """
    bases = track.trajectory(bridged=False)
    if bases is None:
        raise InputError("the intelligent space never saw the robot")
    truth = Trajectory(bases.stamps, bases.T_map_camera * T_base_camera)
    return absolute_trajectory_error(estimate, truth, alignment)


def path_against_space(
    estimate: Trajectory, track: SpaceTrack, T_base_camera: RigidTransform
) -> Trajectory | None:
    """A camera's path as a path of `base_link` in the frame of the intelligent space.

    Args:
        estimate: The camera's path in any frame.
        track: Of the same robot; the poses at the first common time are aligned.
        T_base_camera: Where the camera is mounted.

    Returns:
        None without a common time.
    """
    bases = track.trajectory(bridged=False)
    if bases is None:
        return None
    path = Trajectory(estimate.stamps, estimate.T_map_camera * T_base_camera.inv())
    try:
        return path.moved(alignment_between(path, bases, Alignment.FIRST_POSE))
    except InputError:
        return None


def _planar(T_map_base: RigidTransform, T_map_true: RigidTransform) -> NDArray[np.float64]:
    """(3,) x, y [m] and yaw [rad]."""
    shift = (T_map_base.translation - T_map_true.translation)[:2]
    turn = (T_map_base.rotation * T_map_true.rotation.inv()).as_matrix()
    return np.array([*shift, np.arctan2(turn[1, 0], turn[0, 0])])


def _figures(values: NDArray[np.float64]) -> tuple[float, float, float]:
    """Root mean square, 95th percentile and maximum."""
    rms = float(np.sqrt(np.mean(values**2)))
    return rms, float(np.percentile(values, 95)), float(values.max())
