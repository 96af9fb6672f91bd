"""Observers of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from circumspect.recognition.recognition_result import RecognitionResult
from circumspect.recognition.recognition_step import RecognitionStep


class PipelineObserver(Protocol):
    """Watches a run: a screen, a folder, a dashboard."""

    def on_step(self, step: RecognitionStep) -> None:
        """A frame was processed."""

    def on_end(self, result: RecognitionResult) -> None:
        """The run ended, with or without an error."""


def notify_end(observers: Sequence[PipelineObserver], result: RecognitionResult) -> None:
    """Call `on_end` of all observers, then raise the first exception of them."""
    errors: list[Exception] = []
    for observer in observers:
        try:
            observer.on_end(result)
        except Exception as error:
            errors.append(error)
    if errors:
        raise errors[0]
