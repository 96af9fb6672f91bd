"""From frames to a name: the algorithm, one stage a line."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import Classifier, Prediction
from circumspect.errors import GeometryError
from circumspect.grid import OccupancyGrid
from circumspect.mapping import ModelSettings, ObjectModel, PoseEstimate, PoseEstimator
from circumspect.pipeline.records import (
    CLASSIFIED,
    NO_DEPTH,
    NO_OBJECT,
    NO_POSE,
    TOO_LITTLE,
    PipelineObserver,
    RecognitionResult,
    RecognitionStep,
)
from circumspect.pipeline.stage_clock import StageClock
from circumspect.pipeline.views import share_seen
from circumspect.sensing import RgbdFrame, Segmentation


class RecognitionPipeline:
    """Models one object and names it after every frame."""

    def __init__(
        self,
        segmentation: Segmentation,
        poses: PoseEstimator,
        classifier: Classifier,
        settings: ModelSettings | None = None,
        observers: Sequence[PipelineObserver] = (),
    ) -> None:
        """Put the parts together.

        Args:
            segmentation: Tells the object from its surroundings.
            poses: Says where frames were taken from.
            classifier: Names the object; also says how it wants its grid.
            settings: How frames are fused.
            observers: Told of every step and of the end.
        """
        self.segmentation = segmentation
        self.poses = poses
        self.classifier = classifier
        self.observers = tuple(observers)
        self.model = ObjectModel(settings or ModelSettings())
        self.grid: OccupancyGrid | None = None
        self.prediction: Prediction | None = None
        self._known_xyz: NDArray[np.float64] | None = None
        self._count = 0

    def run(self, frames: Iterable[RgbdFrame]) -> RecognitionResult:
        """Take all frames, telling the observers.

        Whatever ends the run early, Ctrl-C included, the observers' `on_end` gets the steps so
        far before the exception goes on.

        Args:
            frames: In the order in which they were taken.
        """
        steps: list[RecognitionStep] = []
        complete = False
        try:
            for frame in frames:
                step = self.step(frame)
                if steps:
                    steps[-1] = steps[-1].lightened()
                steps.append(step)
                for observer in self.observers:
                    observer.on_step(steps[-1])
            complete = True
        finally:
            result = RecognitionResult(tuple(steps), interrupted=not complete)
            for observer in self.observers:
                observer.on_end(result)
        return result

    def step(self, frame: RgbdFrame) -> RecognitionStep:
        """Take one frame.

        A frame without depth, without the object, or with too little of it changes nothing but
        is told in the step's `outcome`.

        Raises:
            InputError: The frame has no pose and the pose estimator needs one.
        """
        clock = StageClock()
        if not frame.valid.any():
            return self._told(frame, NO_DEPTH, clock)

        # Where the camera was
        with clock.stage("register"):
            pose = self.poses.estimate(frame)
            placed = frame.at(pose.T_map_camera)
        if not pose.certain:
            return self._told(frame, NO_POSE, clock, pose)

        # Which pixels show the object
        with clock.stage("segment"):
            mask = self.segmentation.object_mask(placed, self._known_xyz)
        if not mask.any():
            return self._told(frame, NO_OBJECT, clock, pose)

        # What the object looks like
        with clock.stage("fuse"):
            self.model = self.model.fused(placed, mask, pose.T_map_camera)

        # Its occupancy around the principal axis, ray traced (section 3.2)
        with clock.stage("grid"):
            try:
                cloud = self.model.cloud()
                self._known_xyz = cloud.points_xyz
                bounds = self.classifier.recipe.bounds(cloud)
            except GeometryError:
                return self._told(frame, TOO_LITTLE, clock, pose, int(mask.sum()))
            self.grid = self.model.occupancy(bounds)

        # What it is
        with clock.stage("classify"):
            self.prediction = self.classifier.classify_grid(self.grid)
        return self._told(frame, CLASSIFIED, clock, pose, int(mask.sum()))

    def _told(
        self,
        frame: RgbdFrame,
        outcome: str,
        clock: StageClock,
        pose: PoseEstimate | None = None,
        object_pixels: int = 0,
    ) -> RecognitionStep:
        index, self._count = self._count, self._count + 1
        return RecognitionStep(
            index=index,
            stamp=frame.stamp,
            outcome=outcome,
            pose=pose,
            object_pixels=object_pixels,
            seen=0.0 if self.grid is None else share_seen(self.model.views_xyz, self.grid),
            model=self.model,
            grid=self.grid,
            prediction=self.prediction,
            milliseconds=dict(clock.milliseconds),
        )
