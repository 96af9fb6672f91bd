"""Whether an object resembles the trained classes at all: one decision from two signs.

A network that was trained with a class of other things gives that class a probability, and the
features of an object have a distance to those of the nearest training object. A logistic model
joins the two; it was fitted to objects that were held back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import InputError

SMALLEST = 1e-6
"""Probabilities and distances are kept this far from 0 and 1, so that logarithms exist."""
_FIELDS = ("bias", "other", "distance", "threshold")


@dataclass(frozen=True)
class OpenSetRule:
    """Probability of an object being of one of the classes.

    Attributes:
        bias: Log-odds where both signs are neutral.
        other: Weight of the log-odds of "other".
        distance: Weight of the logarithm of the distance to the nearest training object.
        threshold: From this probability on an object is `in_distribution`.

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
        """Probability of being of one of the classes.

        Args:
            other: (n,) probability of "other", 0 … 1.
            distance: (n,) to the nearest training object, 0 … 2; None where it is unknown.

        Returns:
            (n,) 0 … 1.
        """
        p = np.clip(np.asarray(other, np.float64), SMALLEST, 1.0 - SMALLEST)
        score = self.bias + self.other * np.log(p / (1.0 - p))
        if distance is not None:
            near = np.maximum(np.asarray(distance, np.float64), SMALLEST)
            score = score + self.distance * np.log(near)
        return 1.0 / (1.0 + np.exp(-np.clip(score, -50.0, 50.0)))

    def to_dict(self) -> dict[str, Any]:
        """The rule as JSON types; `from_dict` reads it back."""
        return {name: getattr(self, name) for name in _FIELDS}

    @classmethod
    def from_dict(cls, document: Any) -> OpenSetRule:
        """Read back what `to_dict` made.

        Raises:
            InputError: Not such a document.
        """
        if not isinstance(document, Mapping) or set(document) != set(_FIELDS):
            raise InputError(f"the open-set rule must name {', '.join(_FIELDS)}")
        return cls(**{name: document[name] for name in _FIELDS})
