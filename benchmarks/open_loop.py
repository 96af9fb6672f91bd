"""A tracker on recorded frames: errors, consistency and time."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.evaluation.trajectory_error import Alignment, absolute_trajectory_error
from circumspect.geometry import Trajectory, se3
from circumspect.sensing import RgbdFrame

MIN_ERROR_M = 0.01
"""Smaller errors [m] are harmless and are not expressed in standard deviations."""
RECOVERY_M, RECOVERY_FRAMES = 0.05, 20
"""A tracker has recovered if its last poses are reliable and within this error [m]."""


@dataclass(frozen=True, eq=False)
class TrackedPose:
    """Result of a tracker for a frame.

    Attributes:
        T_map_camera: (4, 4) pose.
        reliable: Whether the tracker flags it as reliable.
        covariance: (6, 6) [rad, m]; None if there is none.
    """

    T_map_camera: NDArray[np.float64]
    reliable: bool = True
    covariance: NDArray[np.float64] | None = None


class OpenLoopTracker(Protocol):
    """Interface of a tracker."""

    def track(self, frame: RgbdFrame) -> TrackedPose:
        """Estimate the pose of a frame."""
        ...

    def finalise(self) -> NDArray[np.float64]:
        """Return (n, 4, 4) all poses after the last correction."""
        ...


@dataclass(frozen=True)
class OpenLoopResult:
    """Figures of one recording.

    Attributes:
        frames: Number of frames.
        ate_mm: Root mean square position error, live, aligned rigidly [mm].
        final_ate_mm: The same after all corrections.
        worst_reliable_mm: Largest position error of a reliable pose in the map of the first one.
        worst_reliable_sigmas: The same in standard deviations along the error.
        nees: Median normalised estimation error squared; χ² with six degrees of freedom has 5.3.
        reliable: Share of reliable poses.
        recovered: Whether the last poses are reliable and correct.
        milliseconds: Median time of a frame.
    """

    frames: int
    ate_mm: float
    final_ate_mm: float
    worst_reliable_mm: float | None
    worst_reliable_sigmas: float | None
    nees: float | None
    reliable: float
    recovered: bool
    milliseconds: float

    def as_dict(self) -> dict[str, float | bool | None]:
        """JSON types."""
        return asdict(self)


def run_open_loop(
    tracker: OpenLoopTracker, frames: Sequence[RgbdFrame], truth: RigidTransform
) -> OpenLoopResult:
    """Track all frames and compare with the truth.

    Args:
        tracker: A new tracker.
        frames: Frames in order of time.
        truth: n true poses, in any frame.
    """
    tracked, spent = [], []
    for frame in frames:
        start = time.perf_counter()
        tracked.append(tracker.track(frame))
        spent.append(time.perf_counter() - start)
    live = np.stack([pose.T_map_camera for pose in tracked])
    final = tracker.finalise()
    true = live[0] @ np.linalg.inv(truth[0].as_matrix()) @ truth.as_matrix()
    errors = np.linalg.norm(live[:, :3, 3] - true[:, :3, 3], axis=1)
    reliable = np.array([pose.reliable for pose in tracked])
    sigmas, nees = _consistency(tracked, true, errors, reliable)
    last = slice(-RECOVERY_FRAMES, None)
    return OpenLoopResult(
        frames=len(frames),
        ate_mm=_ate(live, true),
        final_ate_mm=_ate(final, true),
        worst_reliable_mm=1e3 * float(errors[reliable].max()) if reliable.any() else None,
        worst_reliable_sigmas=sigmas,
        nees=nees,
        reliable=float(reliable.mean()),
        recovered=bool(reliable[last].all() and errors[last].max() < RECOVERY_M),
        milliseconds=1e3 * float(np.median(spent)),
    )


def _ate(poses: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    stamps = np.arange(len(poses), dtype=float)
    found, wanted = (
        Trajectory(stamps, RigidTransform.from_matrix(matrices)) for matrices in (poses, true)
    )
    return 1e3 * absolute_trajectory_error(found, wanted, Alignment.RIGID).rmse_m


def _consistency(
    tracked: Sequence[TrackedPose],
    true: NDArray[np.float64],
    errors: NDArray[np.float64],
    reliable: NDArray[np.bool_],
) -> tuple[float | None, float | None]:
    """Largest error of a reliable pose in standard deviations, and the median NEES."""
    sigmas, nees = [], []
    for pose, T, away, is_reliable in zip(tracked, true, errors, reliable, strict=True):
        if pose.covariance is None:
            continue
        error = se3.log(RigidTransform.from_matrix(np.linalg.inv(T) @ pose.T_map_camera))
        nees.append(float(error @ np.linalg.solve(pose.covariance, error)))
        if is_reliable and away > MIN_ERROR_M:
            shift = error[3:]
            sigma = float(np.sqrt(shift @ pose.covariance[3:, 3:] @ shift)) / away
            sigmas.append(away / sigma)
    return max(sigmas, default=None), float(np.median(nees)) if nees else None
