"""What `circumspect watch` shows while it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from circumspect.cli.node_screen import NodeScreen

if TYPE_CHECKING:
    from circumspect.recognition import RecognitionResult


class WatchScreen(NodeScreen):
    """A line at each change of the answer; a `PipelineObserver`."""

    def on_end(self, result: RecognitionResult) -> None:
        """Nothing: the command reports the end."""
