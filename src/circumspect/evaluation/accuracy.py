"""Accuracy, its confidence interval (Wilson), and the area under the curve of a score."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import rankdata

NORMAL_95 = 1.959964
"""95 % quantile of the absolute value of a standard normal variable."""


def mean_class_accuracy(correct: ArrayLike, labels: NDArray[np.int64], classes: int) -> float:
    """Mean over the occurring classes of the fraction of correct answers.

    Args:
        correct: (n,) 1 or True where the answer is correct; fractions are averaged as well.
        labels: (n,) true classes.
        classes: How many classes there are.
    """
    sums = np.bincount(labels, weights=np.asarray(correct, np.float64), minlength=classes)
    counts = np.bincount(labels, minlength=classes)
    return float(np.mean(sums[counts > 0] / counts[counts > 0]))


def confusion_matrix(
    labels: NDArray[np.int64], answers: NDArray[np.int64], classes: int
) -> NDArray[np.int64]:
    """(c, c) counts: row is the true class, column the answer.

    Args:
        labels: (n,) true classes.
        answers: (n,) predicted classes.
        classes: How many classes there are.
    """
    flat = np.bincount(labels * classes + answers, minlength=classes * classes)
    return flat.reshape(classes, classes)


def area_under_curve(known: NDArray[np.float64], unknown: NDArray[np.float64]) -> float:
    """Probability that a known object scores higher than an unknown one (area under the ROC curve).

    Args:
        known: (n,) scores; n at least 1.
        unknown: (m,) scores; m at least 1.
    """
    ranks = rankdata(np.concatenate([known, unknown]))[: len(known)]
    return float((ranks - (len(known) + 1) / 2).sum() / (len(known) * len(unknown)))


def wilson_interval(hits: int, count: int) -> tuple[float, float]:
    """The 95 % interval of a proportion (Wilson, "Probable inference", JASA 1927).

    It assumes independent objects. Unlike the normal approximation it stays within 0 … 1, and has a
    width if all or none are hits.

    Args:
        hits: Number of hits.
        count: Number of objects, at least 1.

    Raises:
        ValueError: `hits` does not lie in 0 … `count`, or there are no objects.
    """
    if not 0 <= hits <= count or not count:
        raise ValueError(f"{hits} of {count} objects is no share")
    z2 = NORMAL_95**2 / count
    middle = (hits / count + z2 / 2) / (1 + z2)
    half = sqrt(z2 * (hits / count * (1 - hits / count) + z2 / 4)) / (1 + z2)
    # Rounding must not leave an interval that excludes a share of 0 or 1.
    low = 0.0 if hits == 0 else max(0.0, middle - half)
    high = 1.0 if hits == count else min(1.0, middle + half)
    return low, high
