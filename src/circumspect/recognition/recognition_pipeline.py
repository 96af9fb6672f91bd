"""The recognition pipeline: track, segment, fuse, grid, classify."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import Classifier, Prediction
from circumspect.grid import OccupancyGrid
from circumspect.recognition.background_worker import (
    BackgroundTracker,
    BackgroundWorker,
    waits_on_error,
)
from circumspect.recognition.frame_outcome import FrameCheck, FrameOutcome
from circumspect.recognition.object_answer import ObjectAnswer
from circumspect.recognition.object_fusion import ObjectFusion
from circumspect.recognition.recognition_step import RecognitionStep
from circumspect.recognition.stage_clock import StageClock, timed
from circumspect.reconstruction import FrameSurface, ModelSettings, ObjectModel
from circumspect.sensing import RgbdFrame, Segmentation
from circumspect.tracking import OdometryCheck, PoseEstimate, PoseEstimator


class RecognitionPipeline:
    """Models one object and classifies it after every frame.

    Attributes:
        segmentation: Finds the pixels of the object.
        tracker: Estimates the poses of frames.
        classifier: Classifies the object's grids.
        frame_count: Number of frames so far; the index of the next step.
        clock: Times the stages of the latest frame.
        background: Runs work that answers do not depend on.
    """

    def __init__(
        self,
        segmentation: Segmentation,
        tracker: PoseEstimator,
        classifier: Classifier,
        settings: ModelSettings | None = None,
    ) -> None:
        """Start without an object.

        Args:
            segmentation: Finds the pixels of the object.
            tracker: Estimates the poses of frames.
            classifier: Classifies the object. Its input specification defines the grids.
            settings: Settings of fusion.
        """
        self.background = BackgroundWorker()
        self.segmentation = segmentation
        self.tracker = BackgroundTracker(tracker, self.background)
        self.classifier = classifier
        self.frame_count = 0
        self.clock = StageClock()
        self._check, self._odometry_check = FrameCheck(), OdometryCheck()
        self._fusion = ObjectFusion(settings or ModelSettings(), self.tracker, self.background)
        self._answer = ObjectAnswer(classifier)

    @property
    def model(self) -> ObjectModel:
        """The object so far."""
        return self._fusion.model

    @property
    def grid(self) -> OccupancyGrid | None:
        """The ray-traced grid that was classified last; None before the first."""
        return self._answer.grids.first

    @property
    def prediction(self) -> Prediction | None:
        """The latest answer, provisional until `finalise`; None before the first."""
        return self._answer.prediction

    @property
    def coverage(self) -> float:
        """Fraction of the azimuth from which the object has been seen, 0 … 1."""
        return self._answer.grids.coverage

    @waits_on_error
    def step(self, frame: RgbdFrame) -> RecognitionStep:
        """Process one frame.

        An unusable frame changes neither model nor answer; the outcome of the step is the reason.
        Background work may continue until the next frame.

        Raises:
            InputError: The frame has no pose and the pose estimator needs one.
        """
        if (outcome := self._unusable(frame)) is not None:
            return self._skipped(frame, outcome)
        pose = self._track(frame)  # where the camera was
        frame = frame.at(pose.T_map_camera)
        if (outcome := self._pose_fault(frame, pose)) is not None:
            return self._finished(frame, outcome, pose)
        mask = self._segment(frame)  # which pixels show the object
        if not mask.any():
            return self._finished(frame, FrameOutcome.NO_OBJECT, pose)
        self._fuse(frame, mask, pose)  # its surface
        if (outcome := self._grid()) is not None:  # its occupancy (section 3.2)
            return self._finished(frame, outcome, pose, mask)
        self._classify()  # its class
        return self._finished(frame, FrameOutcome.CLASSIFIED, pose, mask)

    def finalise(self) -> bool:
        """Do all deferred work after the last frame; more frames may follow.

        Loops are closed, and all grids of the full model are classified in place of its preview.

        Returns:
            Whether poses, model or answer may have changed.
        """
        self.background.join()
        self.tracker.finalise()
        if self._fusion.finalise():
            self._answer.on_replaced(self.model)
        if not self._answer.is_provisional:
            return False
        self._answer.finalise(self.model)
        return True

    def _unusable(self, frame: RgbdFrame) -> FrameOutcome | None:
        """Start the clock of a frame; return why it cannot be tracked, None if it can."""
        self.clock = StageClock()
        return self._check.check(frame)

    @timed("register")
    def _track(self, frame: RgbdFrame) -> PoseEstimate:
        """Estimate the pose of the camera; the model follows corrections of earlier poses."""
        self.background.join()
        pose = self.tracker.track(self._odometry_check.filter(frame))
        self._odometry_check.update(frame, pose)
        if self._fusion.follow(pose):
            self._answer.on_replaced(self.model)
        self.tracker.process_pending()
        return pose

    def _pose_fault(self, frame: RgbdFrame, pose: PoseEstimate) -> FrameOutcome | None:
        """Why the pose cannot be used; None if it can."""
        if not pose.reliable:
            return FrameOutcome.NO_POSE
        # Once the object is modelled, the floor may be out of view.
        if self._answer.grids.points_xyz is not None:
            return None
        with self.clock.stage("segment"):
            problem = self.segmentation.problem(frame)
        return None if problem is None else FrameOutcome(problem.value)

    @timed("segment")
    def _segment(self, frame: RgbdFrame) -> NDArray[np.bool_]:
        """(height, width) mask of the object's pixels."""
        return self.segmentation.object_mask(frame, self._answer.grids.points_xyz)

    @timed("fuse")
    def _fuse(self, frame: RgbdFrame, mask: NDArray[np.bool_], pose: PoseEstimate) -> None:
        """Add the surface of the object in a frame to the model."""
        surface = FrameSurface.from_frame(frame, mask, pose.T_map_camera)
        if self._fusion.fuse(surface, pose.T_map_camera):
            self._answer.is_provisional = True

    @timed("grid")
    def _grid(self) -> FrameOutcome | None:
        """Grid the model around its principal axis (section 3.2); return why if that fails."""
        return self._answer.grid(self.model)

    @timed("classify")
    def _classify(self) -> None:
        """Classify the grids."""
        self._answer.classify(self.model)

    def _skipped(self, frame: RgbdFrame, outcome: FrameOutcome) -> RecognitionStep:
        """The step of a frame that is not tracked."""
        if outcome is not FrameOutcome.OUT_OF_ORDER:
            self.tracker.skip(frame)
        return self._recorded(frame, outcome)

    def _finished(
        self,
        frame: RgbdFrame,
        outcome: FrameOutcome,
        pose: PoseEstimate,
        mask: NDArray[np.bool_] | None = None,
    ) -> RecognitionStep:
        """The step of a tracked frame; background work may continue until the next one."""
        return self._recorded(frame, outcome, pose, 0 if mask is None else int(mask.sum()))

    def _recorded(
        self,
        frame: RgbdFrame,
        outcome: FrameOutcome,
        pose: PoseEstimate | None = None,
        object_pixels: int = 0,
    ) -> RecognitionStep:
        index, self.frame_count = self.frame_count, self.frame_count + 1
        return RecognitionStep(
            index=index,
            stamp=frame.stamp,
            outcome=outcome,
            pose=pose,
            object_pixels=object_pixels,
            coverage=self.coverage,
            model=self.model,
            grid=self.grid,
            prediction=self.prediction,
            milliseconds=dict(self.clock.milliseconds),
            odometry_warning=self._odometry_check.warning,
        )
