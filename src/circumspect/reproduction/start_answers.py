"""Answers of a classifier to scans of objects from several starts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets import ObjectSet
from circumspect.evaluation.accuracy import confusion_matrix
from circumspect.evaluation.yaw_sweep import YawSweep


@dataclass(frozen=True, eq=False)
class StartAnswers:
    """Answers by the azimuth of the start [degrees].

    Attributes:
        labels: Start to (n,) true classes of its scans.
        answers: Start to (n,) answers; the number of classes stands for any other class.
        objects: Start to (n,) names of the objects.
        classes: The c class names.
    """

    labels: Mapping[float, NDArray[np.int64]]
    answers: Mapping[float, NDArray[np.int64]]
    objects: Mapping[float, NDArray[np.str_]]
    classes: tuple[str, ...]

    @classmethod
    def of_sweeps(cls, sweeps: Mapping[float, YawSweep], tests: Mapping[float, ObjectSet]) -> Self:
        """Of a network that named the scans from each start at yaw 0."""
        return cls(
            {start: sweep.labels for start, sweep in sweeps.items()},
            {start: sweep.answers[0] for start, sweep in sweeps.items()},
            {start: tests[start].shown for start in sweeps},
            next(iter(tests.values())).classes,
        )

    @property
    def accuracy(self) -> dict[float, float]:
        """Start to the share of correct answers."""
        return {
            start: float((answers == self.labels[start]).mean())
            for start, answers in self.answers.items()
        }

    @property
    def changes(self) -> float:
        """Share of the objects that are not called the same from all starts; NaN without any.

        Objects that were scanned from some of the starts only do not count.
        """
        found: dict[str, list[int]] = defaultdict(list)
        for start, answers in self.answers.items():
            for name, answer in zip(self.objects[start].tolist(), answers.tolist(), strict=True):
                found[name].append(answer)
        whole = [answers for answers in found.values() if len(answers) == len(self.answers)]
        return float(np.mean([len(set(a)) > 1 for a in whole])) if whole else float("nan")

    def confusion(self, starts: Sequence[float]) -> NDArray[np.int64]:
        """(c + 1, c + 1) counts over some starts; row is the true class, the last any other."""
        labels = np.concatenate([self.labels[start] for start in starts])
        answers = np.concatenate([self.answers[start] for start in starts])
        return confusion_matrix(labels, answers, len(self.classes) + 1)

    def to_dict(self) -> dict[str, Any]:
        """Accuracy from each start, its mean and its worst, and label changes."""
        accuracy = self.accuracy
        return {
            "accuracy": {f"{start:g}": value for start, value in accuracy.items()},
            "mean": float(np.mean(list(accuracy.values()))),
            "worst": min(accuracy.values()),
            "changes": self.changes,
        }
