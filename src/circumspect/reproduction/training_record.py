"""What trainings tell of themselves afterwards."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from circumspect.evaluation.markdown import table
from circumspect.nets import Checkpoint
from circumspect.training.examiner import YAWS
from circumspect.training.run_log import LOG
from circumspect.training.train import FEWEST_TO_CHOOSE


def training_record(weights: Path) -> dict[str, float]:
    """Which epoch was kept, and what it took.

    Args:
        weights: The checkpoint in a run's folder, beside its `epochs.csv`.

    Returns:
        `epoch` that was kept, of how many `epochs`, its `validation_accuracy`, and `minutes` of
        all epochs, without their measurement on held-back objects.
    """
    reached = Checkpoint.load(weights).training["reached"]
    with (weights.parent / LOG).open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    return {
        "epoch": int(reached["epoch"]),
        "epochs": len(rows),
        "validation_accuracy": float(reached["validation_accuracy"]),
        "minutes": sum(float(row["seconds"]) for row in rows) / 60,
    }


def training_table(names: Sequence[str], records: Sequence[dict[str, Any]]) -> str:
    """The records in Markdown, and in words how an epoch is chosen.

    Args:
        names: Of the networks.
        records: From `training_record`.
    """
    rows = [
        [
            name,
            f"{r['epoch']} of {r['epochs']}",
            f"{r['validation_accuracy']:.3f}",
            f"{r['minutes']:.0f}",
        ]
        for name, r in zip(names, records, strict=True)
    ]
    *yaws, last = (f"{yaw:.0f}°" for yaw in np.rad2deg(YAWS))
    return (
        "The epoch that was kept, and its mean-class accuracy on held-back training objects, at "
        f"{', '.join(yaws)} and {last}; where {FEWEST_TO_CHOOSE} or more are held back it is the "
        "best one by that, else the last:\n\n"
        + table(["network", "epoch", "accuracy on held-back", "minutes"], rows)
        + "\n"
    )
