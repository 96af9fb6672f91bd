"""How commands open the dashboard and wait with it."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from circumspect.classification import Classifier
    from circumspect.viewer import Dashboard


@contextmanager
def opened(classifier: Classifier, host: str, port: int) -> Iterator[Dashboard]:
    """A dashboard whose address is told on standard error.

    Raises:
        InputError: The port is taken.
        MissingExtraError: viser is not installed.
    """
    from circumspect.viewer import Dashboard
    from circumspect.viewer.guarded_server import LOOPBACK

    with Dashboard(classifier, host, port) as dashboard:
        if host not in LOOPBACK:
            say(f"warning: whoever reaches {host} can see this dashboard and steer the robot")
        say(f"the dashboard is at {dashboard.url}; Ctrl-C ends it")
        yield dashboard


def stay() -> None:
    """Wait for Ctrl-C."""
    threading.Event().wait()


def say(text: str) -> None:
    """A line on standard error."""
    print(f"circumspect: {text}", file=sys.stderr, flush=True)  # noqa: T201
