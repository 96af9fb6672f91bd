"""How far an estimated trajectory is from the true one.

The measures are those of Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems"
(IROS 2012), and equal to those of `evo`; the alignment is Umeyama's (PAMI 1991) without scale.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import Trajectory

TOLERANCE = 0.01
"""Poses belong together when their stamps differ by no more than this [s]."""
FEWEST_POSES = 3
"""Fewer places do not determine an alignment."""
_LINE = 1e-9
"""Places are on a line when they spread across it by less than this share of their length."""


class Alignment(Enum):
    """How the estimate is moved onto the truth before the two are compared."""

    RIGID = "rigid"
    """Turned and shifted so that the sum of squared distances is smallest."""
    ORIENTATIONS = "orientations"
    """Turned by the mean difference of the orientations, then shifted by that of the places: also
    determined where the path is a short line."""
    FIRST_POSE = "first pose"
    """Moved so that the first poses agree: what a robot sees that trusts its start."""
    NONE = "none"
    """Not at all: both are in the same frame already."""


@dataclass(frozen=True)
class TrajectoryError:
    """Differences between estimated and true poses.

    Attributes:
        poses: How many were compared.
        rmse_m, median_m, max_m: Of the distances [m].
        rotation_rmse_deg, rotation_median_deg, rotation_max_deg: Of the angles between the
            orientations, in [0, 180] [degrees].
        yaw_rmse_deg, yaw_median_deg, yaw_max_deg: Of the turns about the vertical [degrees].
    """

    poses: int
    rmse_m: float
    median_m: float
    max_m: float
    rotation_rmse_deg: float
    rotation_median_deg: float
    rotation_max_deg: float
    yaw_rmse_deg: float
    yaw_median_deg: float
    yaw_max_deg: float

    @classmethod
    def from_errors(
        cls, distances: NDArray[np.float64], rotations_map: Rotation
    ) -> TrajectoryError:
        """Sum up.

        Args:
            distances: (n,) [m].
            rotations_map: n rotations in the map frame that take true to estimated orientations.
        """
        matrices = rotations_map.as_matrix()
        yaw = np.abs(np.degrees(np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0])))
        angle = np.degrees(rotations_map.magnitude())
        return cls(len(distances), *_summary(distances), *_summary(angle), *_summary(yaw))


def absolute_trajectory_error(
    estimate: Trajectory,
    truth: Trajectory,
    alignment: Alignment = Alignment.RIGID,
    tolerance: float = TOLERANCE,
) -> TrajectoryError:
    """ATE: distances of the estimated places from the true ones after alignment.

    Args:
        estimate: What was estimated.
        truth: What is true; its z is up.
        alignment: How the estimate is moved first.
        tolerance: Largest difference of stamps [s].

    Raises:
        InputError: Fewer than `FEWEST_POSES` stamps in common.
        GeometryError: The places lie on a line, so that no rigid alignment is determined.
    """
    estimate, truth = associated(estimate, truth, tolerance)
    moved = estimate.moved(_alignment(estimate, truth, alignment))
    distances = np.linalg.norm(moved.positions_xyz - truth.positions_xyz, axis=1)
    turns = moved.T_map_camera.rotation * truth.T_map_camera.rotation.inv()
    return TrajectoryError.from_errors(distances, turns)


def places_and_turns(estimate: Trajectory, truth: Trajectory) -> TrajectoryError:
    """Places after the rigid alignment, as is usual; turns after the alignment by turns.

    A path that is short and thin may turn about itself when it is fitted to its places alone.

    Raises:
        InputError, GeometryError: See `absolute_trajectory_error`.
    """
    places = absolute_trajectory_error(estimate, truth)
    turns = absolute_trajectory_error(estimate, truth, Alignment.ORIENTATIONS)
    told = {key: value for key, value in asdict(turns).items() if key.endswith("_deg")}
    return replace(places, **told)


def relative_pose_error(
    estimate: Trajectory, truth: Trajectory, delta_frames: int = 1, tolerance: float = TOLERANCE
) -> TrajectoryError:
    """RPE: errors of the motion from each common pose to the one `delta_frames` later.

    Args:
        estimate: What was estimated.
        truth: What is true; its z is up.
        delta_frames: How many common poses lie between; all pairs are taken.
        tolerance: Largest difference of stamps [s].

    Raises:
        InputError: Too few stamps in common, or `delta_frames` is below 1.
    """
    if delta_frames < 1:
        raise InputError(f"delta_frames {delta_frames}: compare with the 1st, 2nd, … later pose")
    fewest = max(FEWEST_POSES, delta_frames + 1)
    estimate, truth = associated(estimate, truth, tolerance, fewest)
    moved, actual = (
        t.T_map_camera[:-delta_frames].inv() * t.T_map_camera[delta_frames:]
        for t in (estimate, truth)
    )
    errors = actual.inv() * moved
    distances = np.linalg.norm(errors.translation, axis=1)
    # The error is told in the later camera's frame; yaw is about the vertical of the map.
    R_map_camera = truth.T_map_camera[delta_frames:].rotation
    return TrajectoryError.from_errors(
        distances, R_map_camera * errors.rotation * R_map_camera.inv()
    )


def alignment_between(
    estimate: Trajectory,
    truth: Trajectory,
    alignment: Alignment = Alignment.RIGID,
    tolerance: float = TOLERANCE,
) -> RigidTransform:
    """`T_true_estimated`: how the estimate's map frame lies in the true one.

    Args:
        estimate: What was estimated.
        truth: What is true.
        alignment: What is made to agree.
        tolerance: Largest difference of stamps [s].

    Raises:
        InputError: Too few stamps in common.
        GeometryError: As `absolute_trajectory_error`.
    """
    fewest = FEWEST_POSES if alignment is Alignment.RIGID else 1
    return _alignment(*associated(estimate, truth, tolerance, fewest), alignment)


def associated(
    estimate: Trajectory,
    truth: Trajectory,
    tolerance: float = TOLERANCE,
    fewest: int = FEWEST_POSES,
) -> tuple[Trajectory, Trajectory]:
    """The poses of both that were taken at the same times, each used at most once.

    Args:
        estimate: A trajectory.
        truth: Another one.
        tolerance: Largest difference of stamps [s].
        fewest: How many pairs there must be.

    Raises:
        InputError: There are fewer.
    """
    if not tolerance >= 0:
        raise InputError(f"the tolerance of stamps must be 0 s or more, not {tolerance}")
    pairs = _nearest_stamps(estimate.stamps, truth.stamps, tolerance)
    if len(pairs) < fewest:
        raise InputError(
            f"{len(pairs)} of {len(estimate)} estimated and {len(truth)} true poses have stamps "
            f"within {tolerance:g} s of each other; at least {fewest} are needed"
        )
    one, other = pairs.T
    return (
        Trajectory(estimate.stamps[one], estimate.T_map_camera[one]),
        Trajectory(truth.stamps[other], truth.T_map_camera[other]),
    )


def rigid_alignment(
    points_xyz: NDArray[np.float64], targets_xyz: NDArray[np.float64]
) -> RigidTransform:
    """The rotation and translation that bring points nearest to their targets (Umeyama 1991).

    Args:
        points_xyz: (n, 3) [m].
        targets_xyz: (n, 3) [m], in the same order.

    Returns:
        `T_target_point`.

    Raises:
        GeometryError: Points or targets lie on a line or in one place.
    """
    middle, target_middle = points_xyz.mean(axis=0), targets_xyz.mean(axis=0)
    points, targets = points_xyz - middle, targets_xyz - target_middle
    for name, cloud in (("estimated", points), ("true", targets)):
        spread = np.linalg.svd(cloud, compute_uv=False)
        if not spread[1] > _LINE * spread[0]:
            raise GeometryError(
                f"the {name} places lie on a line or in one place, which determines no rigid "
                "alignment; align the first poses instead"
            )
    U, _, Vt = np.linalg.svd(targets.T @ points)
    mirror = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    R = U @ np.diag([1.0, 1.0, mirror]) @ Vt
    return RigidTransform.from_components(target_middle - R @ middle, Rotation.from_matrix(R))


def _alignment(estimate: Trajectory, truth: Trajectory, alignment: Alignment) -> RigidTransform:
    """The same of trajectories that are associated already."""
    match alignment:
        case Alignment.RIGID:
            return rigid_alignment(estimate.positions_xyz, truth.positions_xyz)
        case Alignment.ORIENTATIONS:
            turn = (truth.T_map_camera.rotation * estimate.T_map_camera.rotation.inv()).mean()
            shift = (truth.positions_xyz - turn.apply(estimate.positions_xyz)).mean(axis=0)
            return RigidTransform.from_components(shift, turn)
        case Alignment.FIRST_POSE:
            return truth.T_map_camera[0] * estimate.T_map_camera[0].inv()
        case Alignment.NONE:
            return RigidTransform.identity()


def _nearest_stamps(
    one: NDArray[np.float64], other: NDArray[np.float64], tolerance: float
) -> NDArray[np.int64]:
    """(k, 2) pairs of indices; the shorter list picks from the longer one."""
    if len(one) > len(other):
        return _nearest_stamps(other, one, tolerance)[:, ::-1]
    if len(one) == 0:
        return np.empty((0, 2), np.int64)
    after = np.searchsorted(other, one).clip(1, max(len(other) - 1, 1))
    before, after = after - 1, np.minimum(after, len(other) - 1)
    nearest = np.where(one - other[before] <= np.abs(other[after] - one), before, after)
    apart = np.abs(other[nearest] - one)
    # Of several that picked the same, the nearest has it.
    order = np.lexsort((apart, nearest))
    order = order[np.diff(nearest[order], prepend=-1) > 0]
    kept = np.sort(order[apart[order] <= tolerance])
    return np.stack([kept, nearest[kept]], axis=1)


def _summary(values: NDArray[np.float64]) -> tuple[float, float, float]:
    """Root mean square, median and largest."""
    rmse = float(np.sqrt(np.mean(values**2)))
    return rmse, float(np.median(values)), float(values.max())
