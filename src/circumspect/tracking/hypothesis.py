"""One possible trajectory of the camera, and the evidence for it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.pose_distance import distances
from circumspect.motion import PoseWithCovariance
from circumspect.registration import Registration
from circumspect.tracking.fixed_lag_smoother import FixedLagSmoother
from circumspect.tracking.scan_likelihood import ScanLikelihood

MAX_HYPOTHESES = 3
MAX_FRAME_RATIO = 20.0
"""Largest log-likelihood ratio between two hypotheses that one frame contributes."""
MAP_ERROR_SHARE = 0.1
"""Differences below this share of the support may come from errors of the map; they are no
evidence."""
DECISION_RATIO = 30.0
"""A hypothesis is accepted if its log-likelihood exceeds all others' by this."""
SAME_DISTANCE_M, SAME_ROTATION = 0.05, float(np.radians(4.0))
"""Hypotheses nearer to each other are one."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A trajectory with its accumulated log-likelihood.

    Attributes:
        smoother: Estimate of the most recent poses.
        reference: Number of the reference keyframe.
        motion: Where the last motion comes from: "odometry", "constant velocity", ….
        registration: Of the last scan; None if it was not used.
        likelihood: Of the last scan.
        innovation: Half the squared innovation of the registration, limited.
        frame_log_ratio: Log-likelihood of the last frame: of scan and motion.
        log_ratio: Accumulated, relative to the best hypothesis.
        unmeasured: Time [s] since the last scan that determined the pose.
        unmeasured_distance: How far the camera was assumed to move since then [m].
    """

    smoother: FixedLagSmoother
    reference: int | None = None
    motion: str = "initial pose"
    registration: Registration | None = None
    likelihood: ScanLikelihood = field(default_factory=ScanLikelihood)
    innovation: float = 0.0
    frame_log_ratio: float = 0.0
    log_ratio: float = 0.0
    unmeasured: float = 0.0
    unmeasured_distance: float = 0.0

    @property
    def pose(self) -> PoseWithCovariance:
        """The current pose, with its covariance in the local map."""
        return self.smoother.pose

    @property
    def T_map_camera(self) -> NDArray[np.floating]:
        """(4, 4) the current pose."""
        return self.smoother.T_map_camera

    def with_reference(self, reference: int) -> Hypothesis:
        """The same with another reference keyframe."""
        return replace(self, reference=reference)

    def transformed(self, T_new_old: NDArray[np.floating]) -> Hypothesis:
        """The same in a corrected map."""
        return replace(self, smoother=self.smoother.transformed(T_new_old))

    def coincides_with(self, other: Hypothesis) -> bool:
        """Whether both are at the same pose."""
        translation, rotation = distances(self.T_map_camera, other.T_map_camera)
        return bool(translation < SAME_DISTANCE_M and rotation < SAME_ROTATION)


def survivors(candidates: list[Hypothesis]) -> list[Hypothesis]:
    """Update the sequential test by one frame, and drop what it decides.

    Args:
        candidates: Continued and new hypotheses, each with the log-likelihood of the frame.

    Returns:
        At most `MAX_HYPOTHESES`, the most likely one first. One alone if it is accepted.
    """
    best = max(candidates, key=lambda candidate: candidate.frame_log_ratio)
    as_likely = best.frame_log_ratio - MAP_ERROR_SHARE * max(best.likelihood.support, 0.0)
    updated = [
        replace(c, log_ratio=c.log_ratio + _limited(c.frame_log_ratio - as_likely))
        for c in candidates
    ]
    updated.sort(key=lambda c: c.log_ratio, reverse=True)
    largest = updated[0].log_ratio
    kept: list[Hypothesis] = []
    for candidate in updated:
        alive = candidate.log_ratio > largest - DECISION_RATIO
        if alive and not any(candidate.coincides_with(other) for other in kept):
            kept.append(replace(candidate, log_ratio=candidate.log_ratio - largest))
    return kept[:MAX_HYPOTHESES]


def _limited(log_ratio: float) -> float:
    return min(max(log_ratio, -MAX_FRAME_RATIO), 0.0)
