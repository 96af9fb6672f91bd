"""From frames to a name: the algorithm, one stage a line."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from contextlib import closing, nullcontext
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Classifier, Prediction
from circumspect.errors import GeometryError
from circumspect.grid import CylindricalGrid, Grid, OccupancyGrid, hits_views
from circumspect.recognition.azimuth_coverage import azimuth_coverage
from circumspect.recognition.background_worker import Aside
from circumspect.recognition.object_fusion import ObjectFusion, ReferenceKeyframe
from circumspect.recognition.recognition_step import (
    CLASSIFIED,
    NO_DEPTH,
    NO_OBJECT,
    NO_POSE,
    OUT_OF_ORDER,
    TOO_LITTLE,
    TOO_WIDE,
    WRONG_UNIT,
    PipelineObserver,
    RecognitionResult,
    RecognitionStep,
    reason_of_end,
    tell_end,
)
from circumspect.recognition.stage_clock import StageClock
from circumspect.recognition.step_log import StepLog
from circumspect.reconstruction import FrameSurface, ModelSettings, ObjectModel
from circumspect.sensing import RgbdFrame, Segmentation
from circumspect.tracking import OdometryClockCheck, PoseEstimate, PoseEstimator

SHORTEST, LONGEST = 0.05, 50.0
"""Median depths outside of this [m] are in another unit."""
SPARSE = 16
"""One pixel of each block of this side [px] tells the unit."""
VIEWS_A_FRAME = 4
"""So many of the classifier's grids are asked with a frame, all of them once no more come."""


class RecognitionPipeline:
    """Models one object and names it after every frame.

    Attributes:
        prediction: What it was called last: by a few grids after a frame, by all of the
            classifier's once the model is settled; None before it was.
        coverage: Share of the azimuth from which it has been seen, 0 … 1.
    """

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
            poses: Estimates the poses of frames.
            classifier: Names the object; also says how it wants its grid.
            settings: How frames are fused.
            observers: Told of every step and of the end.
        """
        self.segmentation = segmentation
        self.poses = poses
        self.classifier = classifier
        self.observers = tuple(observers)
        self._odometry_clock = OdometryClockCheck()
        self._fusion = ObjectFusion(settings or ModelSettings(), poses)
        self._grids: list[OccupancyGrid] = []
        self.prediction: Prediction | None = None
        self._known_xyz: NDArray[np.float64] | None = None
        self._stamp: float | None = None
        self._count = 0
        self._is_hurried = False
        self._aside = Aside()
        self.coverage = 0.0

    @property
    def model(self) -> ObjectModel:
        """The object so far."""
        return self._fusion.model

    @property
    def grid(self) -> OccupancyGrid | None:
        """Of the object as it was last named, ray traced."""
        return self._grids[0] if self._grids else None

    def run(self, frames: Iterable[RgbdFrame]) -> RecognitionResult:
        """Take all frames, telling the observers.

        A further run goes on with the object as it is known; its frames are counted from 0 again.

        Whatever ends the run early, Ctrl-C included, the observers' `on_end` gets the steps so
        far before the exception goes on. Before that a generator of frames is closed.

        Args:
            frames: In the order in which they were taken.

        Returns:
            Every step with its pose as it is known at the end; the last one holds model, grid,
            prediction and coverage as they are then.

        Raises:
            InputError: A frame has no pose and the pose estimator needs one.
        """
        log = StepLog()
        complete, cause = False, None
        self._count = 0
        try:
            # What drives for its frames stops before loops are closed and files written.
            with closing(frames) if isinstance(frames, Generator) else nullcontext():
                for frame in frames:
                    step = self.step(frame)
                    log.append(step)
                    for observer in self.observers:
                        observer.on_step(step)
            complete = True
        except BaseException as error:
            cause = error
            raise
        finally:
            steps = log.steps
            try:
                self._end(steps)
            except BaseException as error:
                # A fault gives way to what ended the run; an interrupt is one itself.
                if complete or not isinstance(error, Exception):
                    complete, cause = False, error
                    raise
            finally:
                result = RecognitionResult(tuple(steps), not complete, reason_of_end(cause))
                tell_end(self.observers, result)
        return result

    def step(self, frame: RgbdFrame) -> RecognitionStep:
        """Take one frame.

        A frame that comes too late, without depth, without a reliable pose, without the object, or
        with too little of it adds nothing but is told in the step's `outcome`; so does, before
        anything of the object is known, one without the floor that the segmentation counts on.

        Raises:
            InputError: The frame has no pose and the pose estimator needs one.
        """
        clock = StageClock()
        self._aside.wait()  # after an interrupt something may go on
        if (fault := self._fault(frame)) is not None:
            if fault != OUT_OF_ORDER:
                self.poses.skip(frame)
            return self._told(frame, fault, clock)

        # Where the camera was
        with clock.stage("register"):
            frame = self._odometry_clock.checked(frame)
            pose = self.poses.track(frame)
            self._odometry_clock.update(frame, pose)
            placed = frame.at(pose.T_map_camera)
            self._swap_model()
            self._fusion.follow_corrections()
            reference = self._fusion.reference(pose)
        outcome, pixels = NO_POSE, 0
        try:
            # What no answer waits for is done beside the rest.
            self._aside.begin(self.poses.process_pending)
            self._fusion.fuse_pending(self._aside)
            if pose.reliable:
                outcome, pixels = self._looked_at(placed, pose.T_map_camera, reference, clock)
        except BaseException:
            self._aside.wait()  # what failed there as well is told by the next join
            raise
        with clock.stage("register"):
            self._aside.join()
        return self._told(frame, outcome, clock, pose, pixels)

    def _looked_at(
        self,
        frame: RgbdFrame,
        T_map_camera: RigidTransform,
        reference: ReferenceKeyframe | None,
        clock: StageClock,
    ) -> tuple[str, int]:
        """Model and name what a frame shows.

        Args:
            frame: A frame that brings its pose.
            T_map_camera: That pose.
            reference: Its reference keyframe, if there is one.
            clock: Told of the stages.

        Returns:
            What came of it, and how many pixels show the object.
        """
        # Which pixels show the object
        with clock.stage("segment"):
            # Once the object is known the floor may be out of view.
            fault = self.segmentation.fault(frame) if self._known_xyz is None else None
            mask = self.segmentation.object_mask(frame, self._known_xyz)
        if fault is not None or not mask.any():
            return fault or NO_OBJECT, 0
        pixels = int(mask.sum())

        # What the object looks like
        with clock.stage("fuse"):
            surface = FrameSurface.from_frame(frame, mask, T_map_camera)
            if self._fusion.fuse(surface, T_map_camera, reference, self._aside):
                self._is_hurried = True

        # Its occupancy around the principal axis, ray traced (section 3.2)
        with clock.stage("grid"):
            fault = self._grid_model(self.model.preview, VIEWS_A_FRAME)
        if fault is not None:
            return fault, pixels

        # What it is
        with clock.stage("classify"):
            self._name(self.model.preview)
        return CLASSIFIED, pixels

    def settle(self) -> bool:
        """Do what was put off, as no more frames come for now.

        Loops are closed, and all grids of the full model are asked, not of its preview.

        Returns:
            Whether that may have changed poses, model or answer.
        """
        self._aside.join()
        self.poses.finalise()
        self._fusion.follow_corrections(anyway=True)
        self._fusion.finish()
        if not (self._swap_model() or self._is_hurried):
            return False
        if self._grid_model(self.model) is None:
            self._name(self.model)
        self._is_hurried = False
        return True

    def _fault(self, frame: RgbdFrame) -> str | None:
        """Why a frame can not be used at all."""
        if self._stamp is not None and frame.stamp <= self._stamp:
            return OUT_OF_ORDER
        self._stamp = frame.stamp
        if not frame.valid.any():
            return NO_DEPTH
        some = frame.depth[::SPARSE, ::SPARSE]
        some = some[np.isfinite(some)]
        if len(some) and not SHORTEST < float(np.median(some)) < LONGEST:
            return WRONG_UNIT
        return None

    def _swap_model(self) -> bool:
        """Use the model of a complete fusion of submaps; returns whether there is one."""
        if not self._fusion.swap_model():
            return False
        # No grid is of this model yet, whatever becomes of the next frame.
        self._is_hurried = True
        if self._known_xyz is not None:
            self._known_xyz = self.model.preview.points_xyz
        return True

    def _grid_model(self, model: ObjectModel, most_views: int | None = None) -> str | None:
        """Grid the object and measure its coverage.

        Args:
            model: The object's model, or its preview.
            most_views: Of the classifier's grids at most so many; None means all.

        Returns:
            Why there is nothing to name; None where there is.
        """
        fault = self._fill_grid(model, most_views)
        if fault == TOO_WIDE:
            # Earlier answers are withdrawn; a result from the preview model is provisional.
            self._grids, self.prediction = [], None
            self._is_hurried = model is not self.model
        if self.grid is not None:
            self.coverage = azimuth_coverage(model.views_xyz, self.grid)
        return fault

    def _fill_grid(self, model: ObjectModel, most_views: int | None) -> str | None:
        """Fit and fill the grid; why that is not possible, else None."""
        try:
            cloud = model.cloud()
            self._known_xyz = cloud.points_xyz
            bounds = self.classifier.recipe.bounds(cloud)
        except GeometryError:
            return TOO_LITTLE
        # Column by column: along the rows of two columns it takes milliseconds.
        if max(map(np.ptp, cloud.points_xyz.T[:2])) > model.settings.max_width:
            return TOO_WIDE
        grid = model.occupancy(bounds)
        if not grid.occupied.any():
            return TOO_LITTLE
        # The answer must not hang on where cells begin.
        recipe = self.classifier.recipe
        further = recipe.all_bounds(bounds, most_views)[1:]
        if recipe.visibility and further:
            self._grids = [grid, *model.occupancies(further)]
        else:
            self._grids = [grid, *_filled(further, cloud.points_xyz)]
        return None

    def _name(self, model: ObjectModel) -> None:
        """Ask the classifier.

        Args:
            model: The object's model, or its preview, that the grids are of.
        """
        self.prediction = self.classifier.classify_grid(
            *self._grids, metric=True, coverage=self.coverage
        )
        asked_all = len(self._grids) >= self.classifier.recipe.azimuth_views
        self._is_hurried = model is not self.model or not asked_all

    def _end(self, steps: list[RecognitionStep]) -> None:
        """Bring the steps, as they were told, to what is known when no more frames come."""
        self.settle()
        if not steps:
            return
        told = [number for number, step in enumerate(steps) if step.pose is not None]
        poses = self.poses.corrected([step.pose for step in steps if step.pose is not None])
        for number, T_map_camera in zip(told, poses, strict=True):
            steps[number] = steps[number].at(T_map_camera)
        steps[-1] = replace(
            steps[-1], model=self.model, grid=self.grid, prediction=self.prediction,
            coverage=self.coverage,
        )  # fmt: skip

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
            coverage=self.coverage,
            model=self.model,
            grid=self.grid,
            prediction=self.prediction,
            milliseconds=dict(clock.milliseconds),
            odometry_warning=self._odometry_clock.warning,
        )


def _filled(grids: Sequence[Grid], points_xyz: NDArray[np.float64]) -> list[OccupancyGrid]:
    """Occupancy of further views of an object by hits; cylindrical ones in one pass."""
    if not (grids and isinstance(grids[0], CylindricalGrid)):
        return [grid.hits(points_xyz, threads=0) for grid in grids]
    states = hits_views(grids, points_xyz)
    return [OccupancyGrid(*view) for view in zip(grids, states, strict=True)]
