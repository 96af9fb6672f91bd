"""Opening the dashboard from a command, and waiting for Ctrl-C."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from circumspect.cli.say import say

if TYPE_CHECKING:
    from circumspect.classification import Classifier
    from circumspect.viewer import Dashboard


@dataclass(frozen=True)
class PageFlags:
    """Flags of commands with a dashboard."""

    viewer_port: int = 8080
    """Port of the dashboard; 0 means any free port."""
    viewer_host: str = "127.0.0.1"
    """Address of the dashboard. With any other address, others can see and control the robot."""
    viewer_names: tuple[str, ...] = ()
    """Further host names that browsers may use for a dashboard at another address. This machine's
    own name and numeric addresses are always allowed; all others are rejected."""

    @contextmanager
    def opened(self, classifier: Classifier) -> Iterator[Dashboard]:
        """Open a dashboard and print its address on standard error.

        Raises:
            InputError: The port is taken.
            MissingExtraError: viser is not installed.
        """
        from circumspect.viewer import Dashboard
        from circumspect.viewer.guarded_server import LOOPBACK

        host = self.viewer_host
        with Dashboard(classifier, host, self.viewer_port, names=self.viewer_names) as dashboard:
            if host not in LOOPBACK:
                say(f"warning: whoever reaches {host} can see this dashboard and steer the robot")
            say(f"the dashboard is at {dashboard.url}; Ctrl-C ends it")
            yield dashboard


def stay() -> None:
    """Wait for Ctrl-C."""
    threading.Event().wait()
