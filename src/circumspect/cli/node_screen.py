"""Terminal output of `circumspect ros2` and `watch`."""

from __future__ import annotations

import json
import logging
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from circumspect.classification.answer_text import percent
from circumspect.cli.say import say
from circumspect.ros.log_throttle import LogThrottle

if TYPE_CHECKING:
    from circumspect.classification import Prediction
    from circumspect.recognition import RecognitionResult, RecognitionStep
    from circumspect.ros.health import Status
    from circumspect.ros.node_settings import NodeSettings

CHANGE = 0.05
"""Smallest change of the probability that is printed."""
LOGGER = "circumspect"


class NodeScreen:
    """Prints one line at each change: answers on standard output, states on standard error.

    A `NodeObserver`.
    """

    def __init__(self, as_json: bool) -> None:
        """Attach the log to standard error.

        Args:
            as_json: Print answers as JSON lines.
        """
        self._json = as_json
        self._answer: tuple[str, bool, float] | None = None
        self._state: str | None = None
        self._handler = logging.StreamHandler(sys.stderr)
        self._handler.setFormatter(logging.Formatter("circumspect: %(message)s"))
        self._handler.addFilter(LogThrottle())
        logging.getLogger(LOGGER).addHandler(self._handler)

    def begin(self, settings: NodeSettings, where: str) -> None:
        """Print the subscribed topics.

        Args:
            settings: Settings of the node.
            where: Description of the network.
        """
        odometry = settings.odometry_topic or f"transforms {settings.odom_frame} to the base"
        say(f"{settings.node} listens to {settings.depth_topic}")
        say(f"and {odometry}, {where}; Ctrl-C ends it")

    def end(self) -> None:
        """Detach the log."""
        logging.getLogger(LOGGER).removeHandler(self._handler)

    def on_step(self, step: RecognitionStep) -> None:
        """Print the answer if it changed."""
        prediction = step.prediction
        if prediction is None:
            self._print_none(step)
            return
        before, now = self._answer, (prediction.label, step.confident, prediction.probability)
        if before is not None and before[:2] == now[:2] and abs(before[2] - now[2]) < CHANGE:
            return
        self._answer = now
        if self._json:
            self._print(json.dumps(step.summary()))
            return
        self._print(
            f"{prediction.text}  coverage {percent(step.coverage)}{_not_confident(prediction)}"
        )

    def _print_none(self, step: RecognitionStep) -> None:
        """Print once that there is no longer an answer."""
        if self._answer is None:
            return
        self._answer = None
        self._print(json.dumps(step.summary()) if self._json else f"no answer: {step.outcome}")

    def on_finalised(self, prediction: Prediction) -> None:
        """Print the last answer."""
        say(f"the answer: {prediction.text}{_not_confident(prediction)}")

    def on_status(self, status: Status) -> None:
        """Print the state if it changed."""
        if status.text != self._state:
            self._state = status.text
            say(status.text)

    def on_command(self, command: str) -> None:
        """Print a command that the node received."""
        if command == "reset":
            self._answer = None
        say(command)

    @staticmethod
    def _print(line: str) -> None:
        print(line, flush=True)  # noqa: T201


class WatchScreen(NodeScreen):
    """Prints one line at each change of the answer; a `PipelineObserver`."""

    def on_end(self, result: RecognitionResult) -> None:
        """Do nothing; the command prints the result."""


def _not_confident(prediction: Prediction) -> str:
    return f", not confident: {prediction.reason}" if prediction.reason else ""


@contextmanager
def going_on(seconds: float | None) -> Iterator[Callable[[], bool]]:
    """Yield a function that returns False after the end of the time or SIGTERM.

    Args:
        seconds: The time [s]; None means no limit.
    """
    ended, until = threading.Event(), None if seconds is None else time.monotonic() + seconds

    def end(*_: Any) -> None:
        ended.set()

    def goes_on() -> bool:
        return not ended.is_set() and (until is None or time.monotonic() < until)

    if threading.current_thread() is not threading.main_thread():
        yield goes_on
        return
    before = signal.signal(signal.SIGTERM, end)
    try:
        yield goes_on
    finally:
        signal.signal(signal.SIGTERM, before)
