"""Progress of a training in the terminal: two bars, and one line per epoch."""

from __future__ import annotations

from types import TracebackType

from circumspect.cli.progress import bars


class TrainingProgress:
    """Observes `circumspect.training.train`; a context manager.

    Args:
        epochs: Number of epochs.
    """

    def __init__(self, epochs: int) -> None:
        self._bars = bars()
        self._epochs = epochs
        self._grids = self._bars.add_task("grids", total=None, visible=False, note="")
        self._run = self._bars.add_task("training", total=None, visible=False, note="")

    def __enter__(self) -> TrainingProgress:
        self._bars.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._bars.stop()

    def preparing(self, done: int, total: int) -> None:
        """Show the number of prepared grids."""
        self._bars.update(self._grids, completed=done, total=total, visible=done < total)

    def stepped(self, epoch: int, step: int, steps: int, loss: float) -> None:
        """Show a training step."""
        self._bars.update(
            self._run,
            completed=epoch * steps + step,
            total=self._epochs * steps,
            visible=True,
            note=f"loss {loss:.3f}",
        )

    def finished_epoch(self, row: dict[str, float]) -> None:
        """Print the results of an epoch."""
        text = (
            f"epoch {row['epoch']:.0f}/{self._epochs}  loss {row['loss']:.3f}"
            f"  training {row['training_accuracy']:.3f}"
        )
        if "validation_accuracy" in row:
            text += f"  validation {row['validation_accuracy']:.4f}"
        self._bars.console.print(f"{text}  {row['seconds']:.0f} s", highlight=False)
