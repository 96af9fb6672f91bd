"""Tracking hypotheses and the sequential test between them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.composition import distances
from circumspect.motion import PoseWithCovariance
from circumspect.registration import Registration
from circumspect.tracking.fixed_lag_smoother import FixedLagSmoother
from circumspect.tracking.scan_likelihood import ScanLikelihood

MAX_HYPOTHESES = 3
MAX_FRAME_RATIO = 20.0
"""Largest log-likelihood ratio between two hypotheses that one frame contributes."""
MAP_ERROR_SHARE = 0.1
"""Differences below this fraction of the support are attributed to errors of the map."""
DECISION_RATIO = 30.0
"""A hypothesis is accepted if its log-likelihood exceeds all others' by this."""
SAME_DISTANCE_M, SAME_ROTATION = 0.05, float(np.radians(4.0))
"""Hypotheses nearer to each other than this coincide [m], [rad]."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A possible trajectory with its accumulated log-likelihood.

    Attributes:
        smoother: Estimate of the most recent poses.
        reference: Number of the reference keyframe.
        motion: Source of the last motion: "odometry", "constant velocity", ….
        registration: Of the last scan; None if it was not used.
        likelihood: Of the last scan.
        innovation: Half the squared innovation of the registration, limited.
        frame_log_ratio: Log-likelihood ratio of the last frame, of scan and motion.
        log_ratio: Accumulated log-likelihood ratio relative to the best hypothesis.
        unmeasured: Time since the last scan that determined the pose [s].
        unmeasured_distance: Predicted distance travelled since then [m].
        unmeasured_rotation: Predicted rotation since then [rad].
        T_now_measured: (4, 4) pose at that scan, relative to the current one.
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
    unmeasured_rotation: float = 0.0
    T_now_measured: NDArray[np.floating] = field(default_factory=lambda: np.eye(4))

    @property
    def pose(self) -> PoseWithCovariance:
        """The current pose, with its covariance in the local map."""
        return self.smoother.pose

    @property
    def T_map_camera(self) -> NDArray[np.floating]:
        """(4, 4) the current pose."""
        return self.smoother.T_map_camera

    def with_reference(self, reference: int) -> Hypothesis:
        """The hypothesis with another reference keyframe."""
        return replace(self, reference=reference)

    def transformed(self, T_new_old: NDArray[np.floating]) -> Hypothesis:
        """The hypothesis in a corrected map."""
        return replace(self, smoother=self.smoother.transformed(T_new_old))

    def coincides_with(self, other: Hypothesis) -> bool:
        """Whether both hypotheses have the same pose."""
        translation, rotation = distances(self.T_map_camera, other.T_map_camera)
        return bool(translation < SAME_DISTANCE_M and rotation < SAME_ROTATION)


def survivors(candidates: list[Hypothesis]) -> list[Hypothesis]:
    """Update the sequential test by one frame and drop rejected hypotheses.

    Args:
        candidates: Continued and new hypotheses with the log-likelihood ratio of the frame.

    Returns:
        At most `MAX_HYPOTHESES`, the most likely first; only one if it is accepted.
    """
    best = max(candidates, key=lambda candidate: candidate.frame_log_ratio)
    updated = [replace(c, log_ratio=c.log_ratio + _relative(c, best)) for c in candidates]
    updated.sort(key=lambda c: c.log_ratio, reverse=True)
    largest = updated[0].log_ratio
    kept: list[Hypothesis] = []
    for candidate in updated:
        alive = candidate.log_ratio > largest - DECISION_RATIO
        if alive and not any(candidate.coincides_with(other) for other in kept):
            kept.append(replace(candidate, log_ratio=candidate.log_ratio - largest))
    return kept[:MAX_HYPOTHESES]


def _relative(hypothesis: Hypothesis, best: Hypothesis) -> float:
    """Log-likelihood ratio of the frame relative to the best hypothesis, limited."""
    allowance = MAP_ERROR_SHARE * max(best.likelihood.support, 0.0)
    if hypothesis.unmeasured == 0:
        allowance += best.likelihood.support_of_unknown(hypothesis.likelihood)
    log_ratio = hypothesis.frame_log_ratio - best.frame_log_ratio + allowance
    return min(max(log_ratio, -MAX_FRAME_RATIO), 0.0)
