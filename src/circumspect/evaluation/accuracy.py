"""Accuracy measures."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def mean_class_accuracy(correct: ArrayLike, labels: NDArray[np.int64], classes: int) -> float:
    """Mean over the classes that occur of the share answered rightly.

    Args:
        correct: (n,) 1 or True where the answer is right; shares are averaged as well.
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
