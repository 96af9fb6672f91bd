"""Calibration of probabilities: reliability, expected calibration error and temperature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from circumspect.errors import InputError

BINS = 15
RECALL = 0.95
"""Fraction of known objects that should be in distribution."""
_TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Reliability:
    """Accuracy and mean probability of answers by probability.

    Attributes:
        edges: (b + 1,) of the bins of probability.
        counts: (b,) answers in each.
        accuracy: (b,) fraction of correct answers; NaN without any.
        confidence: (b,) mean probability; NaN without any.
    """

    edges: NDArray[np.float64]
    counts: NDArray[np.int64]
    accuracy: NDArray[np.float64]
    confidence: NDArray[np.float64]

    @classmethod
    def of_sums(
        cls,
        counts: NDArray[np.float64],
        correct: NDArray[np.float64],
        confidence: NDArray[np.float64],
    ) -> Self:
        """Build from what `bins_of` returned."""
        with np.errstate(invalid="ignore", divide="ignore"):
            means = correct / counts, confidence / counts
        return cls(np.linspace(0, 1, BINS + 1), counts.astype(np.int64), *means)

    @property
    def expected_error(self) -> float:
        """Expected calibration error: the mean absolute difference over all answers.

        Guo et al., "On calibration of modern neural networks", ICML 2017, equation 3.
        """
        held = self.counts > 0
        gaps = np.abs(self.accuracy[held] - self.confidence[held])
        return float(gaps @ self.counts[held] / self.counts.sum())


def bins_of(confidence: NDArray[np.float64], correct: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Sums over bins of probability, which can be added.

    Args:
        confidence: (n,) probability of each answer.
        correct: (n,) whether each answer is correct.

    Returns:
        (3, b) answers, correct answers, and the sum of probabilities.
    """
    edges = np.linspace(0, 1, BINS + 1)
    bins = np.clip(np.digitize(confidence, edges[1:-1], right=True), 0, BINS - 1)
    weights = (np.ones(len(bins)), correct, confidence)
    sums = [np.bincount(bins, weights=some, minlength=BINS) for some in weights]
    return np.array(sums, np.float64)


def reliability(probabilities: NDArray[np.float64], labels: NDArray[np.int64]) -> Reliability:
    """Bin answers by their probability.

    Args:
        probabilities: (n, c) that sum to 1 along each row; n at least 1.
        labels: (n,) true classes.
    """
    correct = probabilities.argmax(axis=1) == labels
    return Reliability.of_sums(*bins_of(probabilities.max(axis=1), correct))


def fitted_temperature(probabilities: NDArray[np.float64], labels: NDArray[np.int64]) -> float:
    """The temperature that maximises the likelihood of the labels.

    Temperature scaling (Guo et al. 2017, section 4.2): a small validation split suffices for one
    number, and no answer changes. It multiplies an existing temperature of the probabilities.

    Args:
        probabilities: (n, c) on objects that the network was not trained on.
        labels: (n,) true classes.

    Raises:
        InputError: All answers are correct or all are wrong; no temperature is best.
    """
    right = probabilities.argmax(axis=1) == labels
    if right.all() or not right.any():
        raise InputError("a temperature needs correct answers and wrong ones to be fitted to")
    logits = np.log(np.maximum(probabilities, _TINY))

    def loss(log_temperature: float) -> float:
        scaled = logits / np.exp(log_temperature)
        scaled -= scaled.max(axis=1, keepdims=True)
        total = np.log(np.exp(scaled).sum(axis=1))
        return float(np.mean(total - scaled[np.arange(len(labels)), labels]))

    best: Any = minimize_scalar(loss, bounds=(-3.0, 3.0), method="bounded")
    return float(np.exp(best.x))


def tempered(probabilities: NDArray[np.float64], temperature: float) -> NDArray[np.float64]:
    """The probabilities after dividing the logits by a temperature.

    Args:
        probabilities: (…, c) that sum to 1.
        temperature: Positive.
    """
    logits = np.log(np.maximum(probabilities, _TINY)) / temperature
    powers = np.exp(logits - logits.max(axis=-1, keepdims=True))
    return powers / powers.sum(axis=-1, keepdims=True)


def known_within(distances: NDArray[np.float64], recall: float = RECALL) -> float:
    """The distance from training objects that contains this fraction of known objects.

    Larger distances suggest an unknown object.

    Args:
        distances: (n,) of known objects that the network was not trained on; n at least 1.
        recall: Fraction of them that should be in distribution.
    """
    return float(np.quantile(distances, recall))
