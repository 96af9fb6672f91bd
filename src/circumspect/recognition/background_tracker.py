"""A pose estimator whose deferred work runs in the background."""

from __future__ import annotations

from collections.abc import Sequence

from scipy.spatial.transform import RigidTransform

from circumspect.recognition.background_worker import BackgroundWorker
from circumspect.sensing import RgbdFrame
from circumspect.tracking import PoseEstimate, PoseEstimator


class BackgroundTracker(PoseEstimator):
    """Runs `process_pending` of an estimator in the background; all other methods wait for it."""

    def __init__(self, estimator: PoseEstimator, background: BackgroundWorker) -> None:
        """Wrap an estimator.

        Args:
            estimator: Estimates the poses.
            background: Runs the deferred work.
        """
        self._estimator = estimator
        self._background = background

    def process_pending(self) -> None:
        """Start the work that the last frame left, and return at once."""
        self._background.submit(self._estimator.process_pending)

    def track(self, frame: RgbdFrame) -> PoseEstimate:
        """See `PoseEstimator.track`."""
        return self.estimator.track(frame)

    @property
    def corrections(self) -> int:
        """See `PoseEstimator.corrections`."""
        return self.estimator.corrections

    def keyframe_pose(self, number: int) -> RigidTransform:
        """See `PoseEstimator.keyframe_pose`."""
        return self.estimator.keyframe_pose(number)

    def skip(self, frame: RgbdFrame) -> None:
        """See `PoseEstimator.skip`."""
        self.estimator.skip(frame)

    def finalise(self) -> None:
        """See `PoseEstimator.finalise`."""
        self.estimator.finalise()

    def corrected(self, estimates: Sequence[PoseEstimate]) -> list[RigidTransform]:
        """See `PoseEstimator.corrected`."""
        return self.estimator.corrected(estimates)

    @property
    def estimator(self) -> PoseEstimator:
        """The wrapped estimator, once its deferred work is done."""
        self._background.wait()
        return self._estimator
