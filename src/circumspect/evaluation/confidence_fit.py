"""Fit the bounds of confidence and of the open set to held-back objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.open_set import MIN_VALUE, OpenSetRule
from circumspect.errors import InputError

MAX_ERROR_RATE = 0.02
"""Largest error rate of the confident answers."""
FROM_COVERAGE = (0.0, 0.3, 0.45, 0.6, 0.75, 0.9)
"""Coverages at which the bounds change; a single view covers 0.25."""
NEVER = 1.5
"""A bound that no probability reaches."""
MIN_ANSWERS = 30
"""Answers that a bound needs; with fewer in a range of coverage none is confident there."""
RECALL = 0.95
"""Fraction of the known objects that should be in distribution."""


def least_probability(
    probability: NDArray[np.float64],
    correct: NDArray[np.bool_],
    max_error_rate: float = MAX_ERROR_RATE,
    weight: NDArray[np.float64] | None = None,
) -> float:
    """The smallest bound above which the error rate is at most a given one.

    Args:
        probability: (n,) of the answers.
        correct: (n,) whether each answer is correct.
        max_error_rate: The error rate, 0 … 1.
        weight: (n,) weight of each answer, above 0; equal by default.

    Returns:
        A probability, or `NEVER` if no bound satisfies it or fewer than `MIN_ANSWERS` answers reach
        it.
    """
    order = np.argsort(-probability, kind="stable")
    ranked = probability[order]
    counted = np.ones(len(order)) if weight is None else weight[order]
    wrong = np.cumsum(counted * ~correct[order]) / np.cumsum(counted)
    # A bound includes all or none of the answers with the same probability.
    last = np.append(ranked[1:] < ranked[:-1], True)
    good = np.flatnonzero((wrong <= max_error_rate) & last)
    if not len(good) or good[-1] + 1 < MIN_ANSWERS:
        return NEVER
    return float(ranked[good[-1]])


def fitted_confidence(
    probability: NDArray[np.float64],
    correct: NDArray[np.bool_],
    coverage: NDArray[np.float64],
    without_coverage: float,
    max_error_rate: float = MAX_ERROR_RATE,
    edges: Sequence[float] = FROM_COVERAGE,
) -> ConfidenceRule:
    """A bound for each range of coverage.

    Args:
        probability: (n,) of the answers that are in distribution.
        correct: (n,) whether each is correct; an answer to an object of no class never is.
        coverage: (n,) share of the azimuth seen, 0 … 1.
        without_coverage: The bound for answers whose coverage is unknown.
        max_error_rate: Largest error rate of the confident answers.
        edges: Ascending coverages at which the bound changes.

    Returns:
        A rule whose bounds do not rise with the coverage: more coverage never makes an answer of
        the same probability less trustworthy.
    """
    bounds = []
    for low, high in zip(edges, [*edges[1:], np.inf], strict=True):
        within = (coverage >= low) & (coverage < high)
        bounds.append(least_probability(probability[within], correct[within], max_error_rate))
    falling = np.minimum.accumulate(bounds)
    return ConfidenceRule(
        tuple(edges), tuple(round(float(bound), 4) for bound in falling), without_coverage
    )


def fitted_open_set(
    other: NDArray[np.float64],
    distance: NDArray[np.float64] | None,
    known: NDArray[np.bool_],
    recall: float = RECALL,
) -> OpenSetRule:
    """Fit a logistic model of belonging to one of the classes.

    Both kinds of objects have the same total weight.

    Args:
        other: (n,) probability of "other".
        distance: (n,) to the nearest training object, or None.
        known: (n,) whether the object is of one of the classes.
        recall: Fraction of the known objects that should be in distribution.

    Raises:
        InputError: Objects of one kind only.
    """
    if known.all() or not known.any():
        raise InputError("an open set needs objects of the classes and of other kinds")
    p = np.clip(other, MIN_VALUE, 1.0 - MIN_VALUE)
    signs = [np.ones_like(p), np.log(p / (1.0 - p))]
    if distance is not None:
        signs.append(np.log(np.maximum(distance, MIN_VALUE)))
    features = np.stack(signs, axis=1)
    weights = np.where(known, 0.5 / known.mean(), 0.5 / (~known).mean())
    towards = np.where(known, 1.0, -1.0)

    def loss(factors: NDArray[np.float64]) -> float:
        # A small weight decay keeps the factors finite if the kinds are separable.
        margins = towards * (features @ factors)
        decay = 1e-3 * float(factors[1:] @ factors[1:])
        return float(np.mean(weights * np.logaddexp(0.0, -margins))) + decay

    found: Any = minimize(loss, np.zeros(features.shape[1]), method="BFGS")
    bias, of_other, *rest = (float(value) for value in found.x)
    rule = OpenSetRule(bias, of_other, rest[0] if rest else 0.0)
    belongs = rule.probability(other[known], None if distance is None else distance[known])
    threshold = float(np.clip(np.quantile(belongs, 1.0 - recall), 0.0, 1.0))
    return OpenSetRule(rule.bias, rule.other, rule.distance, threshold)
