"""Records of finished trainings."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from circumspect.errors import InputError
from circumspect.evaluation.markdown import table
from circumspect.nets import Checkpoint
from circumspect.training.run_log import LOG
from circumspect.training.train import MIN_VALIDATION_OBJECTS
from circumspect.training.training_data import YAWS, YAWS_AROUND


def training_record(weights: Path) -> dict[str, float]:
    """Read the kept epoch and the duration of a training.

    Args:
        weights: The checkpoint in a run's folder, beside its `epochs.csv`.

    Returns:
        The kept `epoch`, the number of `epochs`, the `validation_accuracy` of the kept epoch, and
        `minutes` of all epochs without validation.

    Raises:
        InputError: One of the two files lacks this record.
        WeightsError: The checkpoint is broken.
    """
    training = Checkpoint.load(weights).training
    try:
        epochs = int(training["settings"]["epochs"])
        kept = {
            "epoch": int(training["reached"]["epoch"]),
            "epochs": epochs,
            "validation_accuracy": float(training["reached"]["validation_accuracy"]),
        }
    except (KeyError, TypeError, ValueError) as error:
        raise _broken(weights, "does not record how it was trained") from error
    return {**kept, "minutes": sum(_seconds(weights.parent / LOG, epochs)) / 60}


def _seconds(log: Path, epochs: int) -> list[float]:
    """Duration of each epoch of a finished run [s]."""
    try:
        with log.open(encoding="utf-8", newline="") as stream:
            rows = [(int(row["epoch"]), float(row["seconds"])) for row in csv.DictReader(stream)]
    except (OSError, KeyError, TypeError, ValueError, csv.Error) as error:
        raise _broken(log, "can not be read as the record of a training") from error
    seconds = [spent for _, spent in rows]
    whole = [number for number, _ in rows] == list(range(1, epochs + 1))
    if not whole or not all(math.isfinite(spent) and spent >= 0 for spent in seconds):
        raise _broken(log, f"is not the record of {epochs} epochs")
    return seconds


def _broken(file: Path, why: str) -> InputError:
    return InputError(f"{file}: {why}; remove the folder {file.parent}, and it is trained again")


def training_table(
    names: Sequence[str], records: Sequence[dict[str, Any]], random_yaw: bool = False
) -> str:
    """A table of the records in Markdown, with the rule that chooses an epoch.

    Args:
        names: Names of the networks.
        records: Results of `training_record`.
        random_yaw: Whether some networks are trained at random yaw.
    """
    rows = [
        [
            name,
            f"{r['epoch']} of {r['epochs']}",
            f"{r['validation_accuracy']:.3f}",
            f"{r['minutes']:.{0 if r['minutes'] >= 10 else 1}f}",
        ]
        for name, r in zip(names, records, strict=True)
    ]
    around = f" (trained at random yaw: at {_listed(YAWS_AROUND)})" if random_yaw else ""
    return (
        "The epoch that was kept, and its mean-class accuracy on held-back training objects, at "
        f"{_listed(YAWS)}{around}; where {MIN_VALIDATION_OBJECTS} or more are held back it is the "
        "best one by that, else the last:\n\n"
        + table(["network", "epoch", "accuracy on held-back", "minutes"], rows)
        + "\n"
    )


def _listed(yaws: Sequence[float]) -> str:
    """Angles [rad] as a list of degrees in words."""
    *most, last = (f"{yaw:.0f}°" for yaw in np.rad2deg(yaws))
    return f"{', '.join(most)} and {last}"
