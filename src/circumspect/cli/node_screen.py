"""What `circumspect ros2` shows."""

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
    from circumspect.recognition import RecognitionStep
    from circumspect.ros.health import Status
    from circumspect.ros.node_settings import NodeSettings

CHANGE = 0.05
"""The probability is told again when it changed by this."""
LOGGER = "circumspect"


class NodeScreen:
    """One line at each change: answers on standard output, states on standard error.

    A `NodeObserver`.
    """

    def __init__(self, as_json: bool) -> None:
        """Show nothing yet.

        Args:
            as_json: Answers are JSON lines.
        """
        self._json = as_json
        self._answer: tuple[str, bool, float] | None = None
        self._state: str | None = None
        self._handler = logging.StreamHandler(sys.stderr)
        self._handler.setFormatter(logging.Formatter("circumspect: %(message)s"))
        self._handler.addFilter(LogThrottle())
        logging.getLogger(LOGGER).addHandler(self._handler)

    def begin(self, settings: NodeSettings, where: str) -> None:
        """Say what is listened to.

        Args:
            settings: Of the node.
            where: How others are reached, in words.
        """
        odometry = settings.odometry_topic or f"transforms {settings.odom_frame} to the base"
        say(f"{settings.node} listens to {settings.depth_topic}")
        say(f"and {odometry}, {where}; Ctrl-C ends it")

    def end(self) -> None:
        """Give the log back."""
        logging.getLogger(LOGGER).removeHandler(self._handler)

    def on_step(self, step: RecognitionStep) -> None:
        """Tell the answer where it changed."""
        told = step.prediction
        if told is None:
            self._tell_none(step)
            return
        before, now = self._answer, (told.label, step.confident, told.probability)
        if before is not None and before[:2] == now[:2] and abs(before[2] - now[2]) < CHANGE:
            return
        self._answer = now
        if self._json:
            self._print(json.dumps(step.summary()))
            return
        self._print(f"{told.text}  coverage {percent(step.coverage)}{_not_confident(told)}")

    def _tell_none(self, step: RecognitionStep) -> None:
        """Tell once that there is no answer any more."""
        if self._answer is None:
            return
        self._answer = None
        self._print(json.dumps(step.summary()) if self._json else f"no answer: {step.outcome}")

    def on_settled(self, prediction: Prediction) -> None:
        """Tell the last answer."""
        say(f"the answer: {prediction.text}{_not_confident(prediction)}")

    def on_status(self, status: Status) -> None:
        """Tell the state where it changed."""
        if status.text != self._state:
            self._state = status.text
            say(status.text)

    def on_command(self, command: str) -> None:
        """Tell that the node was told something."""
        if command == "reset":
            self._answer = None
        say(command)

    @staticmethod
    def _print(line: str) -> None:
        print(line, flush=True)  # noqa: T201


def _not_confident(prediction: Prediction) -> str:
    return f", not confident: {prediction.reason}" if prediction.reason else ""


@contextmanager
def going_on(seconds: float | None) -> Iterator[Callable[[], bool]]:
    """Gives a function that says whether to go on: until the time is over, or SIGTERM.

    Args:
        seconds: The time [s]; None for no end.
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
