"""How far poses were from the truth as they were told, and how sure the pipeline was of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import Trajectory, se3
from circumspect.mapping import PoseEstimate
from circumspect.pipeline import RecognitionResult, RecognitionStep

SMALL_M = 0.01
"""Errors below this [m] mislead nobody, however sure the pipeline was."""


class LivePoses:
    """Keeps poses as they were told, before later corrections; a `PipelineObserver`."""

    def __init__(self) -> None:
        self.told: list[tuple[float, PoseEstimate | None]] = []

    def on_step(self, step: RecognitionStep) -> None:
        """Keep the step's pose, or that it had none."""
        self.told.append((step.stamp, step.pose))

    def on_end(self, result: RecognitionResult) -> None:
        """Nothing more to keep."""


class Trust(NamedTuple):
    """What the pipeline's confidence was worth; None where no pose was told.

    Attributes:
        worst_trusted_m: The largest error [m] of a pose that was told as certain.
        worst_trusted_sigmas: The largest error of such a pose beyond `SMALL_M` in standard
            deviations, as the pose's covariance told them, along the error.
        trusted: Share of the frames whose pose was.
        worst_sure_m, sure: The same of poses that were told as sure, `PoseEstimate.sure`.
        nees_median: Of the normalised estimation error squared eᵀP⁻¹e over all poses. Where the
            covariances P are right it is that of χ² with six degrees of freedom, 5.3 (Bar-Shalom,
            Li and Kirubarajan, "Estimation with applications to tracking and navigation", 2001,
            section 5.4); above it the pipeline is too sure, below too cautious.
    """

    worst_trusted_m: float | None = None
    worst_trusted_sigmas: float | None = None
    trusted: float | None = None
    nees_median: float | None = None
    worst_sure_m: float | None = None
    sure: float | None = None


def trust(told: list[tuple[float, PoseEstimate | None]], truth: Trajectory) -> Trust:
    """Compare from the first pose on, which defines the map."""
    posed = [(stamp, pose) for stamp, pose in told if pose is not None]
    if not posed:
        return Trust()
    first, pose = posed[0]
    T_map_world = pose.T_map_camera * _at(truth, first).inv()
    trusted, sure, sigmas, nees = [], [], [], []
    for stamp, pose in posed:
        T_map_true = T_map_world * _at(truth, stamp)
        error = se3.log(T_map_true.inv() * pose.T_map_camera)
        away = float(np.linalg.norm(T_map_true.translation - pose.T_map_camera.translation))
        if pose.certain:
            trusted.append(away)
        if pose.sure:
            sure.append(away)
        if pose.covariance is None:
            continue
        nees.append(_squared(error, pose.covariance))
        if pose.certain and away > SMALL_M:
            sigmas.append(_in_sigmas(error[3:], pose.covariance[3:, 3:]))
    return Trust(
        max(trusted, default=None),
        max(sigmas, default=None),
        len(trusted) / len(told),
        float(np.median(nees)) if nees else None,
        max(sure, default=None),
        len(sure) / len(told),
    )


def _at(truth: Trajectory, stamp: float) -> RigidTransform:
    return truth.T_map_camera[int(np.argmin(np.abs(truth.stamps - stamp)))]


def _squared(error: NDArray[np.float64], covariance: NDArray[np.floating]) -> float:
    return float(error @ np.linalg.solve(covariance, error))


def _in_sigmas(shift: NDArray[np.float64], covariance: NDArray[np.floating]) -> float:
    """|s| / √(uᵀPu), with u the direction of the shift s."""
    length = float(np.linalg.norm(shift))
    return length**2 / float(np.sqrt(shift @ covariance @ shift))
