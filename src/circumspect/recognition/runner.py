"""Runs the pipeline over frames and notifies observers."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from contextlib import closing, nullcontext
from dataclasses import replace

from circumspect.errors import CircumspectError
from circumspect.recognition.observer import PipelineObserver, notify_end
from circumspect.recognition.recognition_pipeline import RecognitionPipeline
from circumspect.recognition.recognition_result import RecognitionResult
from circumspect.recognition.recognition_step import RecognitionStep
from circumspect.recognition.step_log import StepLog
from circumspect.robot import RunStopped
from circumspect.sensing import RgbdFrame


def run_pipeline(
    pipeline: RecognitionPipeline,
    frames: Iterable[RgbdFrame],
    observers: Sequence[PipelineObserver] = (),
) -> RecognitionResult:
    """Process all frames and notify the observers.

    A further run continues with the same object; its frames are counted from 0 again.

    Whatever ends the run early, Ctrl-C included, `on_end` of the observers gets the steps so far
    before the exception is raised. A generator of frames is closed before that.

    Args:
        pipeline: Processes each frame.
        frames: In the order in which they were taken.
        observers: Notified of every step and of the end.

    Returns:
        Every step with its pose as it is known at the end; the last one holds the final model,
        grid, prediction and coverage.

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
            # An exception yields to the one that ended the run; an interrupt does not.
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
    # A robot that drives for its frames stops before loops are closed and files are written.
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
