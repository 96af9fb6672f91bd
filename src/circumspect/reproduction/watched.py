"""What an experiment tells of itself while it goes on."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Protocol

from circumspect.training.train import TrainingObserver


class Watched(Protocol):
    """Shows what an experiment is doing."""

    def training(self, name: str, epochs: int) -> AbstractContextManager[TrainingObserver]:
        """While a network is trained."""
        ...

    def measuring(
        self, name: str, counted: str = "objects"
    ) -> AbstractContextManager[Callable[[int, int], None]]:
        """While it is measured; yields a function to call with (done, all) of what is counted."""
        ...
