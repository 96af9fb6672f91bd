"""Whether an object is in distribution: one decision from two signs.

A network with a class of other things returns a probability of that class. The features of an
object have a distance to those of the nearest training object. A logistic model, fitted to
held-back objects, combines both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import InputError

MIN_VALUE = 1e-6
"""Probabilities and distances are clipped to this distance from 0 and 1 before the logarithm."""
_FIELDS = ("bias", "other", "distance", "threshold")


@dataclass(frozen=True)
class OpenSetRule:
    """Probability that an object belongs to one of the classes.

    Attributes:
        bias: Log-odds where both signs are neutral.
        other: Weight of the log-odds of "other".
        distance: Weight of the logarithm of the distance to the nearest training object.
        threshold: An object of at least this probability is `in_distribution`.

    Raises:
        InputError: Numbers that are not finite, or a threshold outside 0 … 1.
    """

    bias: float
    other: float
    distance: float = 0.0
    threshold: float = 0.5

    def __post_init__(self) -> None:
        for name in _FIELDS:
            value = getattr(self, name)
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not isfinite(value):
                raise InputError(f"{name} of the open-set rule must be a number, not {value!r:.40}")
        if not 0.0 <= self.threshold <= 1.0:
            raise InputError(f"the threshold must lie in 0 … 1, not {self.threshold}")

    def probability(
        self, other: ArrayLike, distance: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Probability of belonging to one of the classes.

        Args:
            other: (n,) probability of "other", 0 … 1.
            distance: (n,) to the nearest training object, 0 … 2; None where it is unknown.

        Returns:
            (n,) 0 … 1.
        """
        p = np.clip(np.asarray(other, np.float64), MIN_VALUE, 1.0 - MIN_VALUE)
        score = self.bias + self.other * np.log(p / (1.0 - p))
        if distance is not None:
            near = np.maximum(np.asarray(distance, np.float64), MIN_VALUE)
            score = score + self.distance * np.log(near)
        return 1.0 / (1.0 + np.exp(-np.clip(score, -50.0, 50.0)))

    def to_dict(self) -> dict[str, Any]:
        """The rule as JSON types; `from_dict` reads it."""
        return {name: getattr(self, name) for name in _FIELDS}

    @classmethod
    def from_dict(cls, document: Any) -> OpenSetRule:
        """Read what `to_dict` returned.

        Raises:
            InputError: Not such a document.
        """
        if not isinstance(document, Mapping) or set(document) != set(_FIELDS):
            raise InputError(f"the open-set rule must name {', '.join(_FIELDS)}")
        return cls(**{name: document[name] for name in _FIELDS})
