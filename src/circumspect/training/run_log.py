"""What a run writes while it trains: settings, a CSV row an epoch, TensorBoard."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from torch.utils.tensorboard import SummaryWriter

from circumspect.storage import atomic_open

LOG = "epochs.csv"


class RunLog:
    """Writes the history of a run.

    Args:
        folder: Of the run.
        history: Rows of the epochs already done, when resuming.
    """

    def __init__(self, folder: Path, history: Sequence[Mapping[str, Any]] = ()) -> None:
        self.history = [dict(row) for row in history]
        self._csv = folder / LOG
        self._board = SummaryWriter(str(folder / "tensorboard"), purge_step=len(self.history) + 1)

    def add(self, row: Mapping[str, float]) -> None:
        """Add the row of one epoch.

        Raises:
            OutputError: The file can not be written.
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
    """How many epochs the log of a run tells of; 0 where there is none."""
    try:
        with (folder / LOG).open(encoding="utf-8", newline="") as stream:
            return sum(1 for _ in csv.DictReader(stream))
    except (OSError, ValueError, csv.Error):
        return 0
