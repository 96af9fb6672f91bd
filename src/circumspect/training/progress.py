"""How far a run has come; JSON types, so that a state can hold it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Progress:
    """Epochs that are over, and the one that is not.

    Attributes:
        history: A row of figures for each whole epoch.
        step: Steps of the epoch that is not over.
        loss: Their losses, summed.
        hits: Objects that they named correctly.
        seen: Objects that they showed.
        seconds: They took [s].
        processes: That took them.
    """

    history: list[dict[str, float]]
    step: int = 0
    loss: float = 0.0
    hits: int = 0
    seen: int = 0
    seconds: float = 0.0
    processes: int = 1

    @property
    def epoch(self) -> int:
        """The one that is not over, from 0."""
        return len(self.history)

    def add(self, loss: float, hits: int, seen: int) -> None:
        """Count a step."""
        self.step += 1
        self.loss += loss
        self.hits += hits
        self.seen += seen

    def row(self) -> dict[str, float]:
        """Figures of the epoch."""
        return {
            "epoch": self.epoch + 1,
            "loss": self.loss / self.step,
            "training_accuracy": self.hits / self.seen,
            "seconds": self.seconds,
        }

    def next_epoch(self, row: dict[str, float]) -> Progress:
        """After an epoch whose figures are these."""
        return Progress([*self.history, row], processes=self.processes)
