"""A network's answers on the grids of a shard, as counts that can be added."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.model_description import OBJECTS
from circumspect.datasets.gathered_set import scanned_name
from circumspect.datasets.set_store import SetStore
from circumspect.datasets.shard_file import Rows, ShardFile
from circumspect.evaluation.calibration import Reliability, bins_of
from circumspect.evaluation.predictor import TrainedPredictor, load_predictor

NO_START = ""
"""Start of grids without a scan."""


@dataclass(frozen=True)
class ShardJob:
    """A shard for evaluation.

    Attributes:
        url: Of the set.
        name: Of the shard inside it.
        model: As `load_predictor` takes it.
        threads: Of ONNX Runtime.
    """

    url: str
    name: str
    model: str
    threads: int = 1

    @property
    def key(self) -> str:
        """The shard's name."""
        return self.name


@dataclass(frozen=True, eq=False)
class ShardAnswers:
    """Counts of answers.

    Attributes:
        confusion: Start of the scans [degrees], as text, to (c, c) counts; row is the true class.
        bins: (3, b) answers, correct ones, and the sum of probabilities, by probability.
        fitted: Answers on training objects.
    """

    confusion: dict[str, NDArray[np.int64]]
    bins: NDArray[np.float64]
    fitted: int

    def to_dict(self) -> dict[str, Any]:
        """The counts as JSON types."""
        confusion = {start: counts.tolist() for start, counts in self.confusion.items()}
        return {"confusion": confusion, "bins": self.bins.tolist(), "fitted": self.fitted}

    @classmethod
    def added(cls, records: Iterable[dict[str, Any]]) -> ShardAnswers:
        """The sum of records from `to_dict`, at least one."""
        confusion: dict[str, NDArray[np.int64]] = {}
        bins, fitted = np.zeros(()), 0
        for record in records:
            for start, found in record["confusion"].items():
                confusion[start] = confusion.get(start, 0) + np.array(found, np.int64)
            bins = bins + np.array(record["bins"])
            fitted += record["fitted"]
        return cls(confusion, bins, fitted)

    @property
    def total(self) -> NDArray[np.int64]:
        """(c, c) counts over all starts."""
        return np.sum(list(self.confusion.values()), axis=0)

    @property
    def reliability(self) -> Reliability:
        """Accuracy by probability."""
        return Reliability.of_sums(*self.bins)

    def metrics(self) -> dict[str, Any]:
        """Accuracy over all starts, and from each one."""
        total = self.total
        found = {
            "objects": int(total.sum()),
            "accuracy": accuracy_of(total),
            "mean_class_accuracy": mean_class_accuracy_of(total),
            "expected_calibration_error": self.reliability.expected_error,
            "confusion": total.tolist(),
        }
        if set(self.confusion) != {NO_START}:
            starts = sorted((float(start), start) for start in self.confusion if start)
            found["starts_deg"] = [degrees for degrees, _ in starts]
            found["accuracy_from_start"] = [
                accuracy_of(self.confusion[start]) for _, start in starts
            ]
        return found


def accuracy_of(confusion: NDArray[np.int64]) -> float:
    """Share of correct answers."""
    return float(np.trace(confusion) / confusion.sum())


def mean_class_accuracy_of(confusion: NDArray[np.int64]) -> float:
    """Mean over the occurring classes of the fraction of correct answers."""
    counts = confusion.sum(axis=1)
    return float(np.mean(np.diag(confusion)[counts > 0] / counts[counts > 0]))


def answers_of_shard(job: ShardJob) -> dict[str, Any]:
    """Evaluate a shard; JSON types, with the job's key.

    Raises:
        InputError: The shard is broken.
    """
    predictor = _predictor(job.model, job.threads)
    fitted = _fitted_names(predictor)
    shard = ShardFile(SetStore(job.url), job.name)
    try:
        parts = [
            _answers(shard.rows(group), shard, predictor, fitted).to_dict()
            for group in range(len(shard.groups))
        ]
    finally:
        shard.close()
    return {"key": job.key, **ShardAnswers.added(parts).to_dict()}


@lru_cache(maxsize=1)
def _predictor(model: str, threads: int) -> TrainedPredictor:
    """One network per process, which evaluates many shards."""
    return load_predictor(model, threads)


def _answers(
    rows: Rows, shard: ShardFile, predictor: TrainedPredictor, fitted: set[str]
) -> ShardAnswers:
    shape, classes = shard.head.shape, len(shard.head.classes)
    # Inputs have a channel axis after the views.
    bits = np.unpackbits(rows.packed, axis=1, count=int(np.prod(shape)))
    grids = bits.reshape(len(rows), shape[0], 1, *shape[1:])
    probabilities = predictor.probabilities(grids)
    answers, confidence = probabilities.argmax(axis=1), probabilities.max(axis=1)
    starts = np.array([NO_START if np.isnan(s) else f"{s:g}" for s in rows.starts_deg])
    confusion = {}
    for start in np.unique(starts).tolist():
        counts = np.zeros((classes, classes), np.int64)
        of = starts == start
        np.add.at(counts, (rows.labels[of], answers[of]), 1)
        confusion[start] = counts
    known = sum(name in fitted for name in rows.objects.tolist())
    return ShardAnswers(confusion, bins_of(confidence, answers == rows.labels), known)


def _fitted_names(predictor: TrainedPredictor) -> set[str]:
    """Training objects, by their names and by the names in their scans."""
    names = [name for name in predictor.training.get(OBJECTS) or [] if isinstance(name, str)]
    return {*names, *(object_name for name in names if (object_name := scanned_name(name)))}
