"""How commands open the dashboard and wait with it."""

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
    """Part of every command that has a dashboard."""

    viewer_port: int = 8080
    """The dashboard's port; 0 for any that is free."""
    viewer_host: str = "127.0.0.1"
    """The dashboard's address; another than this lets others see and steer the robot."""
    viewer_names: tuple[str, ...] = ()
    """Host names by which browsers may reach the dashboard at another address, beside this
    machine's own name and addresses in numbers; others are rejected."""

    @contextmanager
    def opened(self, classifier: Classifier) -> Iterator[Dashboard]:
        """A dashboard whose address is told on standard error.

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
