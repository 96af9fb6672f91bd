"""Errors of live poses, and of those that are flagged as reliable or accurate."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import Trajectory, se3
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.tracking import PoseEstimate

MIN_ERROR_M = 0.01
"""Smaller errors [m] are harmless and are not expressed in standard deviations."""


class LivePoses:
    """Records poses before later corrections; a `PipelineObserver`."""

    def __init__(self) -> None:
        self.estimates: list[tuple[float, PoseEstimate | None]] = []

    def on_step(self, step: RecognitionStep) -> None:
        """Record the pose of a step, or None."""
        self.estimates.append((step.stamp, step.pose))

    def on_end(self, result: RecognitionResult) -> None:
        """Do nothing."""


class ReliabilityFigures(NamedTuple):
    """Errors of reliable and accurate poses; None without such poses.

    Attributes:
        worst_reliable_m: Largest error [m] of a reliable pose.
        worst_reliable_sigmas: Largest error of a reliable pose beyond `MIN_ERROR_M` in standard
            deviations along the error, by the covariance of the pose.
        reliable: Share of the frames with a reliable pose.
        worst_accurate_m, accurate: The same for accurate poses, see `PoseEstimate.accurate`.
        nees_median: Median normalised estimation error squared eᵀP⁻¹e of all poses. For consistent
            covariances P it is 5.3, the median of χ² with six degrees of freedom (Bar-Shalom, Li
            and Kirubarajan, "Estimation with applications to tracking and navigation", 2001,
            section 5.4). It is larger if the covariances are too small.
    """

    worst_reliable_m: float | None = None
    worst_reliable_sigmas: float | None = None
    reliable: float | None = None
    nees_median: float | None = None
    worst_accurate_m: float | None = None
    accurate: float | None = None


def reliability_figures(
    estimates: list[tuple[float, PoseEstimate | None]], truth: Trajectory
) -> ReliabilityFigures:
    """Compare poses with the truth; the first pose aligns the map with it."""
    posed = [(stamp, pose) for stamp, pose in estimates if pose is not None]
    if not posed:
        return ReliabilityFigures()
    first, pose = posed[0]
    T_map_world = pose.T_map_camera * _at(truth, first).inv()
    reliable, accurate, sigmas, nees = [], [], [], []
    for stamp, pose in posed:
        T_map_true = T_map_world * _at(truth, stamp)
        error = se3.log(T_map_true.inv() * pose.T_map_camera)
        away = float(np.linalg.norm(T_map_true.translation - pose.T_map_camera.translation))
        if pose.reliable:
            reliable.append(away)
        if pose.accurate:
            accurate.append(away)
        if pose.covariance is None:
            continue
        nees.append(_squared(error, pose.covariance))
        if pose.reliable and away > MIN_ERROR_M:
            sigmas.append(_in_sigmas(error[3:], pose.covariance[3:, 3:]))
    return ReliabilityFigures(
        max(reliable, default=None),
        max(sigmas, default=None),
        len(reliable) / len(estimates),
        float(np.median(nees)) if nees else None,
        max(accurate, default=None),
        len(accurate) / len(estimates),
    )


def _at(truth: Trajectory, stamp: float) -> RigidTransform:
    return truth.T_map_camera[int(np.argmin(np.abs(truth.stamps - stamp)))]


def _squared(error: NDArray[np.float64], covariance: NDArray[np.floating]) -> float:
    return float(error @ np.linalg.solve(covariance, error))


def _in_sigmas(shift: NDArray[np.float64], covariance: NDArray[np.floating]) -> float:
    """|s| / √(uᵀPu), with u the direction of the shift s."""
    length = float(np.linalg.norm(shift))
    return length**2 / float(np.sqrt(shift @ covariance @ shift))
