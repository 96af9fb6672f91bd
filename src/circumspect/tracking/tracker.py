"""The tracker: scan-to-map registration, odometry and several hypotheses in one estimator."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3_matrices
from circumspect.motion import MotionModel
from circumspect.pose_graph import KeyframeMap
from circumspect.registration import Scan
from circumspect.sensing import RgbdFrame
from circumspect.tracking.fixed_lag_smoother import LAG, FixedLagSmoother
from circumspect.tracking.hypothesis import Hypothesis, survivors
from circumspect.tracking.hypothesis_evaluation import (
    SCALE_SIGMA,
    FrameInput,
    HypothesisEvaluation,
)
from circumspect.tracking.initial_pose import InitialPose
from circumspect.tracking.pose_estimate import PoseEstimate
from circumspect.tracking.pose_estimator import PoseEstimator
from circumspect.tracking.relocaliser import candidate_poses, is_vague
from circumspect.tracking.tracking_settings import TrackingSettings
from circumspect.tracking.tracking_state import TrackingState, TrackingStatus


class Tracker(PoseEstimator):
    """Estimates camera poses from scans and odometry, and builds their map.

    The map frame is the odom frame of the first frame; without odometry it is the frame in which
    the first pose is given.
    """

    def __init__(
        self,
        T_map_first: RigidTransform | None = None,
        settings: TrackingSettings | None = None,
    ) -> None:
        """Start with an empty map.

        Args:
            T_map_first: Pose of the first frame. None means its odometry and mount, or else the
                pose that the frame has, or else its mount.
            settings: Settings of all parts.
        """
        self.settings = s = settings or TrackingSettings()
        self.keyframes = KeyframeMap(
            s.scan.voxel, s.motion.level_covariance, s.keyframes, s.registration
        )
        self._evaluation = HypothesisEvaluation(
            self.keyframes, MotionModel(s.motion), s.registration
        )
        self._status = TrackingStatus(s)
        self._initial_pose = InitialPose(T_map_first)
        self._hypotheses: list[Hypothesis] = []
        self._previous: RgbdFrame | None = None
        self._stamps: deque[float] = deque(maxlen=LAG + 1)
        self._keyframe: tuple[RgbdFrame, Scan] | None = None  # to be added
        self._is_finalised = False

    @property
    def state(self) -> TrackingState:
        """State of the tracker."""
        return self._status.state

    def track(self, frame: RgbdFrame) -> PoseEstimate:
        """See `PoseEstimator.track`."""
        self.process_pending()
        self._is_finalised = False
        scan = Scan.from_frame(frame, self.settings.scan)
        if not self._hypotheses or self._previous is None:
            return self._initialise(frame, scan)
        self._stamps.append(frame.stamp)
        data = FrameInput(frame, self._previous, scan, self._stamps)

        candidates = [self._evaluation.continued(h, data) for h in self._hypotheses]
        best = max(candidates, key=lambda c: c.log_ratio + c.frame_log_ratio)
        may_be_elsewhere = best.likelihood.contradicts or is_vague(self._hypotheses[0].pose)
        if may_be_elsewhere and len(scan) >= self.settings.min_points:
            candidates += self._relocalised(data)
        self._hypotheses = [self._referenced(h) for h in survivors(candidates)]

        self._status.update(self._hypotheses)
        self._previous = frame
        if self.state is TrackingState.TRACKING and self._is_new_view(scan):
            self._keyframe = frame, scan
        return self._estimate(frame)

    def _initialise(self, frame: RgbdFrame, scan: Scan) -> PoseEstimate:
        """Start the map with the first frame that has enough points."""
        pose = self._initial_pose.at(frame, self.settings.motion)
        smoother = FixedLagSmoother.from_pose(pose.T_map_camera, pose.covariance, SCALE_SIGMA)
        self._hypotheses, self._previous = [Hypothesis(smoother)], frame
        if len(scan) < self.settings.min_points:
            reason = f"no map yet: {len(scan)} points in range"
            estimate = replace(self._estimate(frame), reason=reason)
            self._hypotheses = []
            return estimate
        self._stamps.append(frame.stamp)
        key = self.keyframes.add(frame, scan, pose, None)
        self._hypotheses = [Hypothesis(smoother, key.number)]
        self._status.start()
        return self._estimate(frame)

    def _relocalised(self, data: FrameInput) -> list[Hypothesis]:
        """New hypotheses elsewhere in the map that the frame confirms."""
        starts = candidate_poses(data.scan, self.keyframes)
        previous = self._hypotheses[0]
        found = [self._evaluation.relocalised(start, previous, data) for start in starts]
        return [h for h in found if h.unmeasured == 0 and h.likelihood.recognises]

    def _referenced(self, hypothesis: Hypothesis) -> Hypothesis:
        T = hypothesis.T_map_camera
        reference = self.keyframes.reference(T, hypothesis.reference)
        return hypothesis.with_reference(reference)

    def _is_new_view(self, scan: Scan) -> bool:
        best = self._hypotheses[0]
        found = best.registration
        if best.unmeasured > 0 or found is None or len(scan) < self.settings.min_points:
            return False
        if best.reference is None:
            return False
        overlap = found.inliers / found.points
        return self.keyframes.shows_new_view(best.T_map_camera, best.reference, overlap)

    def process_pending(self) -> None:
        """See `PoseEstimator.process_pending`."""
        # A frame that adds a keyframe registers pairs only if older ones still wait.
        is_due = self._keyframe is None or self.keyframes.has_pending
        if self._keyframe is not None:
            (frame, scan), self._keyframe = self._keyframe, None
            best = self._hypotheses[0]
            key = self.keyframes.add(frame, scan, best.pose, best.reference)
            self._hypotheses[0] = best.with_reference(key.number)
        if is_due:
            self._follow(self.keyframes.process_pending)

    def finalise(self) -> None:
        """See `PoseEstimator.finalise`."""
        self.process_pending()
        if not self._is_finalised:
            self._follow(self.keyframes.finalise)
            self._is_finalised = True  # not before: it may be interrupted

    def _follow(self, correct: Callable[[], bool]) -> None:
        """Correct the keyframes, and move the hypotheses with their reference keyframes."""
        before = self._reference_poses()
        if correct():
            corrections = self._reference_poses() @ se3_matrices.inverse(before)
            self._hypotheses = [
                hypothesis.transformed(correction)
                for hypothesis, correction in zip(self._hypotheses, corrections, strict=True)
            ]

    def _reference_poses(self) -> NDArray[np.floating]:
        """(n, 4, 4) `T_map_camera` of the hypotheses' reference keyframes."""
        numbers = [h.reference for h in self._hypotheses if h.reference is not None]
        poses = [self.keyframes.pose_of(number, np.eye(4)) for number in numbers]
        return np.array(poses).reshape(-1, 4, 4)

    @property
    def corrections(self) -> int:
        """See `PoseEstimator.corrections`."""
        return self.keyframes.corrections

    def keyframe_pose(self, number: int) -> RigidTransform:
        """See `PoseEstimator.keyframe_pose`."""
        return RigidTransform.from_matrix(self.keyframes.pose_of(number, np.eye(4)))

    def corrected(self, estimates: Sequence[PoseEstimate]) -> list[RigidTransform]:
        """See `PoseEstimator.corrected`."""
        return [self._corrected(estimate) for estimate in estimates]

    def _corrected(self, estimate: PoseEstimate) -> RigidTransform:
        number, T_reference_camera = estimate.reference, estimate.T_reference_camera
        if number is not None and T_reference_camera is not None:
            # Frames of forgotten keyframes keep their poses.
            with suppress(KeyError):
                T = self.keyframes.pose_of(number, T_reference_camera.as_matrix())
                return RigidTransform.from_matrix(T)
        return estimate.T_map_camera

    def _estimate(self, frame: RgbdFrame) -> PoseEstimate:
        """The estimate of a frame from the best hypothesis."""
        best, status = self._hypotheses[0], self._status
        estimate = PoseEstimate.from_hypothesis(best, frame, self.keyframes)
        return replace(
            estimate,
            state=status.state,
            reason=status.reason,
            unverified=status.unverified,
            hypotheses=len(self._hypotheses),
        )

    def skip(self, frame: RgbdFrame) -> None:
        """See `PoseEstimator.skip`."""
        if not self._hypotheses:
            self._initial_pose.skip(frame)
