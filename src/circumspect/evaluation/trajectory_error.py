"""Errors of an estimated trajectory.

The measures are those of Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems" (IROS
2012), and equal to those of `evo`. The alignment is Umeyama's (PAMI 1991) without scale.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import GeometryError, InputError
from circumspect.figure_canvas import ACCENT, INK, axes_or_new
from circumspect.geometry import Trajectory
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.storage import write_json

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TOLERANCE = 0.01
"""Largest difference of associated stamps [s]."""
MIN_POSES = 3
"""Smallest number of poses; fewer do not determine an alignment."""
_LINE = 1e-9
"""Positions are on a line if they spread across it by less than this fraction of its length."""


class Alignment(Enum):
    """Alignment of the estimate with the truth before the comparison."""

    RIGID = "rigid"
    """Rigid, with the smallest sum of squared distances."""
    ORIENTATIONS = "orientations"
    """By the mean difference of the orientations, then of the positions: also determined for a
    short straight path."""
    FIRST_POSE = "first pose"
    """First poses agree: the error for a robot that trusts its start."""
    NONE = "none"
    """None: both are in the same frame already."""


@dataclass(frozen=True)
class TrajectoryError(ReadOnlyArrays):
    """Differences between estimated and true poses.

    Attributes:
        poses: Number of compared poses.
        rmse_m, median_m, max_m: Of the distances [m].
        rotation_rmse_deg, rotation_median_deg, rotation_max_deg: Of the angles between the
            orientations, in [0, 180] [degrees].
        yaw_rmse_deg, yaw_median_deg, yaw_max_deg: Of the rotations about the vertical [degrees].
        stamps: (n,) of the poses [s]; not compared, nor are the distances.
        distances_m: (n,) of each pose from the true one [m].
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
    stamps: NDArray[np.float64] = field(
        default_factory=lambda: np.empty(0), repr=False, compare=False
    )
    distances_m: NDArray[np.float64] = field(
        default_factory=lambda: np.empty(0), repr=False, compare=False
    )

    @classmethod
    def from_errors(
        cls,
        distances: NDArray[np.float64],
        rotations_map: Rotation,
        stamps: NDArray[np.float64],
    ) -> TrajectoryError:
        """Summarise differences.

        Args:
            distances: (n,) [m].
            rotations_map: n rotations in the map frame that take true to estimated orientations.
            stamps: (n,) [s].
        """
        matrices = rotations_map.as_matrix()
        yaw = np.abs(np.degrees(np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0])))
        angle = np.degrees(rotations_map.magnitude())
        summary = *_summary(distances), *_summary(angle), *_summary(yaw)
        distances.flags.writeable = False
        return cls(len(distances), *summary, stamps, distances)

    def to_dict(self) -> dict[str, float]:
        """The figures in JSON types, without the distance of each pose."""
        return {
            one.name: getattr(self, one.name)
            for one in fields(self)
            if one.name not in ("stamps", "distances_m")
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_dict` as JSON.

        Raises:
            OutputError: The file cannot be written.
        """
        write_json(path, self.to_dict())

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the distance of each pose from the true one over the time.

        Args:
            axes: Where to draw; None for a new figure.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        axes, rmse_mm = axes_or_new(axes), 1e3 * self.rmse_m
        if len(self.stamps):
            axes.plot(self.stamps - self.stamps[0], 1e3 * self.distances_m, color=ACCENT)
        axes.axhline(rmse_mm, color=INK, lw=1, ls="--", label=f"RMSE {rmse_mm:.1f} mm")
        axes.set(xlabel="time [s]", ylabel="distance from the true pose [mm]")
        axes.set_ylim(bottom=0)
        axes.legend(frameon=False)
        axes.spines[["top", "right"]].set_visible(False)
        return axes


def absolute_trajectory_error(
    estimate: Trajectory,
    truth: Trajectory,
    alignment: Alignment = Alignment.RIGID,
    tolerance: float = TOLERANCE,
) -> TrajectoryError:
    """ATE: distances of the estimated positions from the true ones after alignment.

    Args:
        estimate: The estimated trajectory.
        truth: The true trajectory; its z is up.
        alignment: See `Alignment`.
        tolerance: Largest difference of stamps [s].

    Raises:
        InputError: Fewer than `MIN_POSES` stamps in common.
        GeometryError: The positions lie on a line, so that no rigid alignment is determined.
    """
    estimate, truth = associated(estimate, truth, tolerance)
    moved = estimate.moved(_alignment(estimate, truth, alignment))
    distances = np.linalg.norm(moved.positions_xyz - truth.positions_xyz, axis=1)
    turns = moved.T_map_camera.rotation * truth.T_map_camera.rotation.inv()
    return TrajectoryError.from_errors(distances, turns, truth.stamps)


def places_and_turns(estimate: Trajectory, truth: Trajectory) -> TrajectoryError:
    """Positions after the rigid alignment, as is usual; rotations after the alignment by rotations.

    A short, thin path may turn about itself when it is aligned by its positions alone.

    Raises:
        InputError, GeometryError: See `absolute_trajectory_error`.
    """
    places = absolute_trajectory_error(estimate, truth)
    turns = absolute_trajectory_error(estimate, truth, Alignment.ORIENTATIONS)
    angles = {key: value for key, value in turns.to_dict().items() if key.endswith("_deg")}
    return replace(places, **angles)


def relative_pose_error(
    estimate: Trajectory, truth: Trajectory, delta_frames: int = 1, tolerance: float = TOLERANCE
) -> TrajectoryError:
    """RPE: errors of the motion from each common pose to the one `delta_frames` later.

    Args:
        estimate: The estimated trajectory.
        truth: The true trajectory; its z is up.
        delta_frames: Distance of the poses in a pair; all pairs are taken.
        tolerance: Largest difference of stamps [s].

    Raises:
        InputError: Too few stamps in common, or `delta_frames` is below 1.
    """
    if delta_frames < 1:
        raise InputError(f"delta_frames {delta_frames}: compare with the 1st, 2nd, … later pose")
    min_pairs = max(MIN_POSES, delta_frames + 1)
    estimate, truth = associated(estimate, truth, tolerance, min_pairs)
    moved, actual = (
        t.T_map_camera[:-delta_frames].inv() * t.T_map_camera[delta_frames:]
        for t in (estimate, truth)
    )
    errors = actual.inv() * moved
    distances = np.linalg.norm(errors.translation, axis=1)
    # The error is in the later camera's frame; yaw is about the vertical of the map.
    R_map_camera = truth.T_map_camera[delta_frames:].rotation
    return TrajectoryError.from_errors(
        distances,
        R_map_camera * errors.rotation * R_map_camera.inv(),
        truth.stamps[delta_frames:],
    )


def alignment_between(
    estimate: Trajectory,
    truth: Trajectory,
    alignment: Alignment = Alignment.RIGID,
    tolerance: float = TOLERANCE,
) -> RigidTransform:
    """`T_true_estimated`: pose of the estimate's map frame in the true one.

    Args:
        estimate: The estimated trajectory.
        truth: The true trajectory.
        alignment: See `Alignment`.
        tolerance: Largest difference of stamps [s].

    Raises:
        InputError: Too few stamps in common.
        GeometryError: As `absolute_trajectory_error`.
    """
    min_pairs = MIN_POSES if alignment is Alignment.RIGID else 1
    return _alignment(*associated(estimate, truth, tolerance, min_pairs), alignment)


def associated(
    estimate: Trajectory,
    truth: Trajectory,
    tolerance: float = TOLERANCE,
    min_pairs: int = MIN_POSES,
) -> tuple[Trajectory, Trajectory]:
    """Associate poses by their stamps, each at most once.

    Args:
        estimate: A trajectory.
        truth: Another one.
        tolerance: Largest difference of stamps [s].
        min_pairs: Smallest number of pairs.

    Raises:
        InputError: There are fewer pairs.
    """
    if not tolerance >= 0:
        raise InputError(f"the tolerance of stamps must be 0 s or more, not {tolerance}")
    pairs = _nearest_stamps(estimate.stamps, truth.stamps, tolerance)
    if len(pairs) < min_pairs:
        raise InputError(
            f"{len(pairs)} of {len(estimate)} estimated and {len(truth)} true poses have stamps "
            f"within {tolerance:g} s of each other; at least {min_pairs} are needed"
        )
    one, other = pairs.T
    return (
        Trajectory(estimate.stamps[one], estimate.T_map_camera[one]),
        Trajectory(truth.stamps[other], truth.T_map_camera[other]),
    )


def rigid_alignment(
    points_xyz: NDArray[np.float64], targets_xyz: NDArray[np.float64]
) -> RigidTransform:
    """The rigid transform that brings points nearest to their targets (Umeyama 1991).

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
    """Alignment of associated trajectories."""
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
    """(k, 2) pairs of indices; each pose of the shorter list picks one of the longer."""
    if len(one) > len(other):
        return _nearest_stamps(other, one, tolerance)[:, ::-1]
    if len(one) == 0:
        return np.empty((0, 2), np.int64)
    after = np.searchsorted(other, one).clip(1, max(len(other) - 1, 1))
    before, after = after - 1, np.minimum(after, len(other) - 1)
    nearest = np.where(one - other[before] <= np.abs(other[after] - one), before, after)
    apart = np.abs(other[nearest] - one)
    # If several picked the same, the nearest one keeps it.
    order = np.lexsort((apart, nearest))
    order = order[np.diff(nearest[order], prepend=-1) > 0]
    kept = np.sort(order[apart[order] <= tolerance])
    return np.stack([kept, nearest[kept]], axis=1)


def _summary(values: NDArray[np.float64]) -> tuple[float, float, float]:
    """Root mean square, median and maximum."""
    rmse = float(np.sqrt(np.mean(values**2)))
    return rmse, float(np.median(values)), float(values.max())
