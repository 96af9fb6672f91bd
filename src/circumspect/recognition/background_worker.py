"""Runs work on another core while a frame is processed."""

from __future__ import annotations

import functools
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Concatenate, ParamSpec, Protocol, TypeVar


class BackgroundWorker:
    """Runs calls one after the other in a thread of its own.

    The state that a call changes must not be read before `join` or `wait`. The results then do not
    depend on which of the two threads is faster.
    """

    def __init__(self) -> None:
        self._executor = ThreadPoolExecutor(1, "background")
        self._submitted: list[Future[None]] = []
        self._expected = 0

    def submit(self, work: Callable[[], None]) -> None:
        """Run a call after those that were submitted before."""
        self._expected += 1
        self._submitted.append(self._executor.submit(work))

    def wait(self) -> None:
        """Wait for all submitted calls; their exceptions are raised by `join`."""
        if self._expected > len(self._submitted):
            # An interrupt came between the hand-over of a call and its entry in the list. A
            # further call ends after all of them.
            wait([self._executor.submit(_do_nothing)])
            self._expected = len(self._submitted)
        wait([call for call in self._submitted if not call.done()])

    def join(self) -> None:
        """Wait for all submitted calls, and raise what they raised.

        Raises:
            Exception: The first exception of the calls. The other calls ran nevertheless.
        """
        self.wait()  # if this is interrupted, the next join waits
        submitted, self._submitted, self._expected = self._submitted, [], 0
        for call in submitted:
            call.result()


class HasBackground(Protocol):
    """Has a background worker."""

    background: BackgroundWorker


P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T", bound=HasBackground)


def waits_on_error(
    method: Callable[Concatenate[T, P], R],
) -> Callable[Concatenate[T, P], R]:
    """Let a method wait for the background work of its object before it raises."""

    @functools.wraps(method)
    def guarded(self: T, *args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return method(self, *args, **kwargs)
        except BaseException:
            self.background.wait()
            raise

    return guarded


def _do_nothing() -> None:
    """The last call of a queue."""
