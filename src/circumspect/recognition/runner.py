"""Runs the pipeline over frames, notifies observers and logs the steps."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from contextlib import closing, nullcontext
from dataclasses import replace
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import CircumspectError
from circumspect.geometry.growing_table import GrowingTable
from circumspect.recognition.recognition_pipeline import RecognitionPipeline
from circumspect.recognition.recognition_step import RecognitionResult, RecognitionStep
from circumspect.reconstruction import ModelSettings, ObjectModel
from circumspect.robot import RunStopped
from circumspect.sensing import RgbdFrame
from circumspect.tracking import PoseEstimate

_CAMERA, _REFERENCE, _COVARIANCE, _COLUMNS = slice(0, 16), slice(16, 32), slice(32, 68), 68
_ELSEWHERE = RigidTransform.identity()
"""Placeholder of a pose whose numbers are in the table."""


class PipelineObserver(Protocol):
    """Observer of a run, such as a screen, a folder or a dashboard."""

    def on_step(self, step: RecognitionStep) -> None:
        """Called after each processed frame."""

    def on_end(self, result: RecognitionResult) -> None:
        """Called at the end of the run, with or without an error."""


def notify_end(observers: Sequence[PipelineObserver], result: RecognitionResult) -> None:
    """Call `on_end` of all observers, then raise the first exception of them."""
    errors: list[Exception] = []
    for observer in observers:
        try:
            observer.on_end(result)
        except Exception as error:
            errors.append(error)
    if errors:
        raise errors[0]


class StepLog:
    """Keeps the latest step complete, and earlier ones without model and grid.

    Poses and covariances are in one table.
    """

    def __init__(self) -> None:
        """Start empty."""
        self._steps: list[RecognitionStep] = []
        self._poses = GrowingTable(_COLUMNS)

    def append(self, step: RecognitionStep) -> None:
        """Add the next step."""
        if self._steps:
            self._steps[-1] = self._packed(self._steps[-1])
        self._steps.append(step)

    @property
    def steps(self) -> list[RecognitionStep]:
        """All steps so far; only the latest holds model and grid."""
        rows = self._poses.rows
        before = [_unpacked(step, row) for step, row in zip(self._steps, rows, strict=False)]
        return [*before, *self._steps[len(rows) :]]

    def _packed(self, step: RecognitionStep) -> RecognitionStep:
        pose = step.pose
        self._poses.append(np.full(_COLUMNS, np.nan) if pose is None else _row(pose))
        if pose is not None:
            pose = replace(pose, T_map_camera=_ELSEWHERE, T_reference_camera=None, covariance=None)
        model = _without_surface(step.model.settings)
        return replace(step, model=model, grid=None, pose=pose)


def _row(pose: PoseEstimate) -> NDArray[np.float64]:
    """The numbers of a pose; NaN for missing ones."""
    row = np.full(_COLUMNS, np.nan)
    row[_CAMERA] = pose.T_map_camera.as_matrix().ravel()
    if pose.T_reference_camera is not None:
        row[_REFERENCE] = pose.T_reference_camera.as_matrix().ravel()
    if pose.covariance is not None:
        row[_COVARIANCE] = pose.covariance.ravel()
    return row


def _unpacked(step: RecognitionStep, row: NDArray[np.float64]) -> RecognitionStep:
    if step.pose is None:
        return step
    camera, in_reference = _transform(row[_CAMERA]), _transform(row[_REFERENCE])
    assert camera is not None
    covariance = None if np.isnan(row[_COVARIANCE.start]) else row[_COVARIANCE].reshape(6, 6)
    pose = replace(
        step.pose, T_map_camera=camera, T_reference_camera=in_reference, covariance=covariance
    )
    return replace(step, pose=pose)


def _transform(numbers: NDArray[np.float64]) -> RigidTransform | None:
    # Without normalisation the pose is restored exactly.
    return None if np.isnan(numbers[0]) else RigidTransform(numbers.reshape(4, 4), normalize=False)


@lru_cache(maxsize=4)
def _without_surface(settings: ModelSettings) -> ObjectModel:
    """One empty model for all steps."""
    return ObjectModel(settings)


def run_pipeline(
    pipeline: RecognitionPipeline,
    frames: Iterable[RgbdFrame],
    observers: Sequence[PipelineObserver] = (),
) -> RecognitionResult:
    """Process all frames and notify the observers.

    A further run continues with the same object; its frames are counted from 0 again.

    If an exception ends the run early, Ctrl-C included, a generator of frames is closed, `on_end`
    of the observers gets the steps so far, and the exception is raised.

    Args:
        pipeline: Processes each frame.
        frames: The frames in the order of time.
        observers: Notified of every step and of the end.

    Returns:
        All steps with their final poses; the last one holds the final model, grid, prediction and
        coverage.

    Raises:
        InputError: A frame has no pose and the pose estimator needs one.
    """
    log = StepLog()
    complete, cause = False, None
    pipeline.frame_count = 0
    try:
        _process(pipeline, frames, observers, log)
        complete = True
    except BaseException as error:
        cause = error
        raise
    finally:
        steps = log.steps
        try:
            _finalise(pipeline, steps)
        except BaseException as error:
            # The exception that ended the run takes precedence, except over an interrupt.
            if complete or not isinstance(error, Exception):
                complete, cause = False, error
                raise
        finally:
            result = RecognitionResult(tuple(steps), not complete, _end_reason(cause))
            notify_end(observers, result)
    return result


def _process(
    pipeline: RecognitionPipeline,
    frames: Iterable[RgbdFrame],
    observers: Sequence[PipelineObserver],
    log: StepLog,
) -> None:
    # Stops a robot that drives for its frames before loops are closed and files are written.
    with closing(frames) if isinstance(frames, Generator) else nullcontext():
        for frame in frames:
            step = pipeline.step(frame)
            log.append(step)
            for observer in observers:
                observer.on_step(step)


def _finalise(pipeline: RecognitionPipeline, steps: list[RecognitionStep]) -> None:
    """Update the steps to the final poses, and the last one to the final model and answer."""
    pipeline.finalise()
    if not steps:
        return
    numbers = [number for number, step in enumerate(steps) if step.pose is not None]
    estimates = [step.pose for step in steps if step.pose is not None]
    poses = pipeline.tracker.corrected(estimates)
    for number, T_map_camera in zip(numbers, poses, strict=True):
        steps[number] = steps[number].at(T_map_camera)
    steps[-1] = replace(
        steps[-1], model=pipeline.model, grid=pipeline.grid, prediction=pipeline.prediction,
        coverage=pipeline.coverage,
    )  # fmt: skip


def _end_reason(cause: BaseException | None) -> str:
    """Why a run ended early, in words; empty if it did not, or by Ctrl-C."""
    if not isinstance(cause, Exception):
        return ""
    return str(cause) if isinstance(cause, CircumspectError | RunStopped) else repr(cause)
