"""Continues a hypothesis by one frame: predict, register, smooth, evaluate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3_matrices
from circumspect.geometry.composition import orthonormal
from circumspect.motion import MotionModel, PoseWithCovariance, RelativeMotion
from circumspect.motion.motion_model import MAX_EXTRAPOLATION
from circumspect.pose_graph import KeyframeMap
from circumspect.registration import Registration, RegistrationSettings, Scan, register
from circumspect.sensing import RgbdFrame
from circumspect.tracking.fixed_lag_smoother import (
    UNMEASURED,
    FixedLagSmoother,
    LevelFactor,
    PoseFactor,
)
from circumspect.tracking.hypothesis import Hypothesis
from circumspect.tracking.scan_likelihood import ScanLikelihood, scan_likelihood
from circumspect.tracking.start_poses import start_poses

MIN_POINTS = 50
"""Scans with fewer points and registrations with fewer inliers are not used."""
START_SAMPLE = 1000
"""Number of scan points in the comparison of several starts."""
MIN_SUPPORT = 5.0
"""A scan determines the pose if its support is at least this."""
ALTERNATIVE_PENALTY, RELOCALISATION_PENALTY = 4.0, 10.0
"""Negative log prior of a motion that differs from the odometry, and of a relocalisation."""
MAX_INNOVATION_PENALTY = 50.0
"""Upper bound of the log-likelihood penalty for the innovation of a registration."""
MAX_SQUARED_INNOVATION = 10.6
"""Alternatives are evaluated above this innovation: χ² with six degrees of freedom, 90 %."""
UNEXPLAINED_SIGMAS = np.array([np.radians(1.0)] * 3 + [0.02] * 3)
"""Standard deviations added to a dead-reckoned motion if the frame contradicts the map [rad, m]."""
SCALE_SIGMA = 0.05
"""Initial standard deviation of the odometry scale."""


@dataclass(frozen=True, eq=False)
class FrameInput:
    """The input that continues a hypothesis by one frame.

    Attributes:
        frame: The frame.
        previous: The frame before it.
        scan: Its scan.
        stamps: Times of the last frames, this one included [s], ascending.
    """

    frame: RgbdFrame
    previous: RgbdFrame
    scan: Scan
    stamps: Sequence[float]

    @property
    def time(self) -> float:
        """Time since the previous frame [s]."""
        return max(self.stamps[-1] - self.stamps[-2], 1e-3)

    @property
    def time_sigma(self) -> float:
        """Standard deviation of that time [s].

        It is the deviation of the interval from the median interval, limited to the latter: frames
        may be stamped on arrival.
        """
        usual = float(np.median(np.diff(self.stamps)))
        return min(abs(self.time - usual), usual)

    @property
    def level(self) -> NDArray[np.floating] | None:
        """(4, 4) mount of the camera."""
        mount = self.frame.T_base_camera
        return None if mount is None else mount.as_matrix()


class HypothesisEvaluation:
    """Continues hypotheses by one frame, and starts new ones."""

    def __init__(
        self, keyframes: KeyframeMap, motion: MotionModel, registration: RegistrationSettings
    ) -> None:
        """Set the map, the motion model and the settings of registration."""
        self._keyframes, self._motion, self._registration = keyframes, motion, registration
        self._level_covariance = motion.settings.level_covariance
        self._level_information = np.linalg.inv(self._level_covariance)

    def continued(self, hypothesis: Hypothesis, data: FrameInput) -> Hypothesis:
        """The hypothesis after a frame, by the motion that explains the frame best.

        The first choice is odometry, or constant velocity without odometry. If the frame does not
        confirm it, slipping wheels and constant velocity, or standing still, are evaluated. If the
        frame contradicts it, so is dead reckoning without the scan.
        """
        motions = self._motions(hypothesis, data)
        first = self._by_motion(hypothesis, motions[0], data)
        if not _is_doubtful(first):
            return first
        candidates = [first]
        for motion in motions[1:]:
            candidates.append(self._by_motion(hypothesis, motion, data, ALTERNATIVE_PENALTY))
        if first.likelihood.contradicts:
            candidates.append(self._dead_reckoned(hypothesis, motions[0], data))
        return max(candidates, key=lambda candidate: candidate.frame_log_ratio)

    def relocalised(
        self, start: PoseWithCovariance, previous: Hypothesis, data: FrameInput
    ) -> Hypothesis:
        """A new hypothesis at a candidate pose of the relocaliser.

        Args:
            start: The candidate.
            previous: The best hypothesis before the frame; provides the odometry scale.
            data: The frame.
        """
        prior = self._levelled(start, data)
        found = self._registered(prior, prior.T_map_camera, data.scan)
        posterior = PoseWithCovariance(
            found.T_map_camera.as_matrix(), np.linalg.inv(found.information)
        )
        smoother = FixedLagSmoother.from_pose(
            posterior.T_map_camera, posterior.covariance, SCALE_SIGMA, previous.smoother.scale
        )
        fresh = Hypothesis(smoother, log_ratio=previous.log_ratio, motion="relocalisation")
        return self._evaluated(fresh, found, data, RELOCALISATION_PENALTY)

    def _motions(self, hypothesis: Hypothesis, data: FrameInput) -> list[RelativeMotion]:
        """Possible motions since the previous frame, the most likely one first."""
        time, unmeasured, model = data.time, hypothesis.unmeasured, self._motion
        asked = min(time, model.settings.max_extrapolation)
        back, elapsed = 0, 0.0
        window = len(hypothesis.smoother.window.poses)
        while back + 1 < window and elapsed * MAX_EXTRAPOLATION < asked:
            back += 1
            elapsed = data.stamps[-2] - data.stamps[-2 - back]
        recent = hypothesis.smoother.recent_motion(back)
        odometry = model.by_odometry(data.previous, data.frame)
        velocity = model.by_constant_velocity(recent, elapsed, time, unmeasured, data.time_sigma)
        if odometry is None or data.level is None:
            return [velocity, model.by_standing_still(time, unmeasured)]
        slipping = model.by_slipping_wheels(
            odometry, data.level, hypothesis.T_now_measured,
            hypothesis.unmeasured_distance, hypothesis.unmeasured_rotation,
        )  # fmt: skip
        return [odometry, slipping, velocity]

    def _by_motion(
        self, hypothesis: Hypothesis, motion: RelativeMotion, data: FrameInput, penalty: float = 0.0
    ) -> Hypothesis:
        """Predict, register, smooth, evaluate."""
        prior = self._levelled(hypothesis.smoother.predicted(motion), data)
        found = None if len(data.scan) < MIN_POINTS else self._best_registration(prior, data)
        if found is not None and not _is_measurement(found):
            found = None
        start = prior.T_map_camera if found is None else found.T_map_camera.as_matrix()
        smoother = hypothesis.smoother.extended(
            motion, start, _factor(found), self._level_factor(data)
        )
        moved = _moved(hypothesis, smoother, motion)
        return self._evaluated(moved, found, data, penalty)

    def _dead_reckoned(
        self, hypothesis: Hypothesis, motion: RelativeMotion, data: FrameInput
    ) -> Hypothesis:
        """Continue by the motion alone, because the scan shows something that is not in the map."""
        further = np.diag(UNEXPLAINED_SIGMAS**2)
        motion = replace(motion, covariance=motion.covariance + further, source="dead reckoning")
        prior = self._levelled(hypothesis.smoother.predicted(motion), data)
        smoother = hypothesis.smoother.extended(
            motion, prior.T_map_camera, UNMEASURED, self._level_factor(data)
        )
        moved = _moved(hypothesis, smoother, motion)
        return self._evaluated(moved, None, data, 0.0)

    def _evaluated(
        self,
        hypothesis: Hypothesis,
        found: Registration | None,
        data: FrameInput,
        penalty: float,
    ) -> Hypothesis:
        likelihood = ScanLikelihood()
        if len(data.scan) >= MIN_POINTS:
            likelihood = scan_likelihood(
                data.frame, data.scan, self._keyframes, hypothesis.T_map_camera
            )
        innovation = 0.0 if found is None else _innovation(found)
        occam = 0.0 if found is None else found.log_occam_factor()
        measured = found is not None and _is_measurement(found) and not likelihood.contradicts
        measured = measured and likelihood.support >= MIN_SUPPORT
        return replace(
            hypothesis,
            registration=found,
            likelihood=likelihood,
            innovation=innovation,
            frame_log_ratio=likelihood.total - innovation + occam - penalty,
            unmeasured=0.0 if measured else hypothesis.unmeasured + data.time,
            unmeasured_distance=0.0 if measured else hypothesis.unmeasured_distance,
            unmeasured_rotation=0.0 if measured else hypothesis.unmeasured_rotation,
            T_now_measured=np.eye(4) if measured else hypothesis.T_now_measured,
        )

    def _best_registration(self, prior: PoseWithCovariance, data: FrameInput) -> Registration:
        """Register from the best of several starts, which are compared on few points."""
        starts = start_poses(prior)
        if len(starts) == 1:
            return self._registered(prior, starts[0], data.scan)
        sample = data.scan.subsampled(max(1, len(data.scan) // START_SAMPLE))
        found = [self._registered(prior, start, sample) for start in starts]
        best = max(found, key=lambda registration: self._log_ratio(registration, data))
        return self._registered(prior, best.T_map_camera.as_matrix(), data.scan)

    def _registered(
        self, prior: PoseWithCovariance, start: NDArray[np.floating], scan: Scan
    ) -> Registration:
        return register(
            scan,
            self._keyframes.surface_map,
            orthonormal(prior.T_map_camera),
            prior.information,
            self._registration,
            orthonormal(start),
        )

    def _log_ratio(self, found: Registration, data: FrameInput) -> float:
        if not _is_measurement(found):
            return -np.inf
        T = found.T_map_camera.as_matrix()
        likelihood = scan_likelihood(data.frame, data.scan, self._keyframes, T)
        return likelihood.total - _innovation(found)

    def _levelled(self, pose: PoseWithCovariance, data: FrameInput) -> PoseWithCovariance:
        return pose if data.level is None else pose.levelled(data.level, self._level_covariance)

    def _level_factor(self, data: FrameInput) -> LevelFactor | None:
        return None if data.level is None else LevelFactor(data.level, self._level_information)


def _moved(
    hypothesis: Hypothesis, smoother: FixedLagSmoother, motion: RelativeMotion
) -> Hypothesis:
    return replace(
        hypothesis,
        smoother=smoother,
        motion=motion.source,
        unmeasured_distance=hypothesis.unmeasured_distance + motion.distance,
        unmeasured_rotation=hypothesis.unmeasured_rotation + motion.rotation,
        T_now_measured=se3_matrices.inverse(motion.T_before_now) @ hypothesis.T_now_measured,
    )


def _is_measurement(found: Registration) -> bool:
    """Whether a registration determines the pose."""
    return found.converged and found.inliers >= MIN_POINTS


def _innovation(found: Registration) -> float:
    """Half the squared innovation, limited."""
    return min(found.squared_innovation() / 2, MAX_INNOVATION_PENALTY)


def _factor(found: Registration | None) -> PoseFactor:
    return UNMEASURED if found is None else PoseFactor(*found.measured())


def _is_doubtful(hypothesis: Hypothesis) -> bool:
    """Whether a frame does not confirm the predicted motion."""
    return not hypothesis.likelihood.confirms or 2 * hypothesis.innovation > MAX_SQUARED_INNOVATION
