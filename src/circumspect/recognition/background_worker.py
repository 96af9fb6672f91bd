"""Background thread for work that runs while a frame is processed."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Concatenate, ParamSpec, Protocol, TypeVar

from scipy.spatial.transform import RigidTransform

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
        """Start the deferred work of the last frame and return immediately."""
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
        """The wrapped estimator; waits for its deferred work."""
        self._background.wait()
        return self._estimator


class BackgroundWorker:
    """Runs calls one after the other in its own thread.

    State that a call changes must not be read before `join` or `wait`. The results then do not
    depend on the relative speed of the threads.
    """

    def __init__(self) -> None:
        self._executor = ThreadPoolExecutor(1, "background")
        self._submitted: list[Future[None]] = []
        self._expected = 0

    def submit(self, work: Callable[[], None]) -> None:
        """Run a call after the earlier ones."""
        self._expected += 1
        self._submitted.append(self._executor.submit(work))

    def wait(self) -> None:
        """Wait for all submitted calls; their exceptions are raised by `join`."""
        if self._expected > len(self._submitted):
            # An interrupt came between the submission of a call and its entry in the list. A
            # further call ends after all of them.
            wait([self._executor.submit(_do_nothing)])
            self._expected = len(self._submitted)
        wait([call for call in self._submitted if not call.done()])

    def join(self) -> None:
        """Wait for all submitted calls, and raise what they raised.

        Raises:
            Exception: The first exception of the calls; the other calls ran as well.
        """
        self.wait()  # if this is interrupted, the next join waits
        submitted, self._submitted, self._expected = self._submitted, [], 0
        for call in submitted:
            call.result()


class HasBackground(Protocol):
    """An object with a background worker."""

    background: BackgroundWorker


P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T", bound=HasBackground)


def waits_on_error(
    method: Callable[Concatenate[T, P], R],
) -> Callable[Concatenate[T, P], R]:
    """Decorate a method to wait for the background work of its object before it raises."""

    @functools.wraps(method)
    def guarded(self: T, *args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return method(self, *args, **kwargs)
        except BaseException:
            self.background.wait()
            raise

    return guarded


def _do_nothing() -> None:
    """Do nothing; the last call of a queue."""
