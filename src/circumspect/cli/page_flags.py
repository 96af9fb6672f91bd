"""The flags that say where a dashboard is shown."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING

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

    def opened(self, classifier: Classifier) -> AbstractContextManager[Dashboard]:
        """A dashboard whose address is told on standard error; see `dashboard_page.opened`."""
        from circumspect.cli.dashboard_page import opened

        return opened(classifier, self.viewer_host, self.viewer_port)
