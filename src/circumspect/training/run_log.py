"""The log of a run: settings, a CSV row per epoch, TensorBoard."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from torch.utils.tensorboard import SummaryWriter

from circumspect.storage import atomic_open

LOG = "epochs.csv"


class RunLog:
    """Writer of a run's history.

    Args:
        folder: Folder of the run.
        history: Rows of the finished epochs of a resumed run.
    """

    def __init__(self, folder: Path, history: Sequence[Mapping[str, Any]] = ()) -> None:
        self.history = [dict(row) for row in history]
        self._csv = folder / LOG
        self._board = SummaryWriter(str(folder / "tensorboard"), purge_step=len(self.history) + 1)

    def add(self, row: Mapping[str, float]) -> None:
        """Add the row of one epoch.

        Raises:
            OutputError: The file cannot be written.
        """
        self.history.append(dict(row))
        for name, value in row.items():
            if name != "epoch":
                self._board.add_scalar(name, value, int(row["epoch"]))
        self._board.flush()
        with atomic_open(self._csv) as stream:
            writer = csv.DictWriter(stream, fieldnames=list(self.history[0]))
            writer.writeheader()
            writer.writerows(self.history)

    def close(self) -> None:
        """Close the TensorBoard file."""
        self._board.close()


def logged_epochs(folder: Path) -> int:
    """Number of epochs in the log of a run; 0 without a log."""
    try:
        with (folder / LOG).open(encoding="utf-8", newline="") as stream:
            return sum(1 for _ in csv.DictReader(stream))
    except (OSError, ValueError, csv.Error):
        return 0
