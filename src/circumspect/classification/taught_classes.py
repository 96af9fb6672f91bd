"""Classes that a classifier learns from a few examples, by the features of its network.

An object is of a taught class if its features are nearer to an example of it than to those of any
training object, and within the radius of the class. Otherwise the network's answer stays.
`evaluation.teaching` chooses radius and slope.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError

MIN_DISTANCE = 1e-6
"""Distances are clipped to this before the logarithm."""
NOT_OF_IT = -60.0
"""Log-odds of a taught class for other objects: the network's answer stays."""
MAX_SLOPE = 20.0
MAX_EXAMPLES = 1000
"""Largest number of examples of a class."""


@dataclass(frozen=True, eq=False)
class TaughtClass:
    """A class defined by examples.

    Attributes:
        name: Of the class.
        features: (n, f) float32 features of the examples.
        radius: Distance from the nearest example within which objects are of the class, 0 … 2.
        slope: Of the log-odds over the logarithm of the distance.

    Raises:
        InputError: The features are no rows of finite numbers, or a number is out of range.
    """

    name: str
    features: NDArray[np.float32]
    radius: float
    slope: float

    def __post_init__(self) -> None:
        if self.features.ndim != 2 or not 0 < len(self.features) <= MAX_EXAMPLES:
            raise InputError(f"features of {self.name} must be (n, f), not {self.features.shape}")
        lengths = np.linalg.norm(self.features, axis=1)
        if not np.isfinite(lengths).all() or lengths.min() == 0:
            raise InputError(f"features of {self.name} must be finite and not all zero")
        if not (_is_number(self.radius) and 0 < self.radius <= 2):
            raise InputError(
                f"the radius of {self.name} must lie in 0 … 2, not {self.radius!r:.40}"
            )
        if not (_is_number(self.slope) and 0 < self.slope <= MAX_SLOPE):
            raise InputError(
                f"the slope of {self.name} must lie in 0 … {MAX_SLOPE:g}, not {self.slope!r:.40}"
            )

    def require_width(self, width: Any) -> None:
        """Check that a network's features have the width of the class's features.

        Args:
            width: Of the features; no number where the network does not say.

        Raises:
            InputError: Another number.
        """
        if isinstance(width, int) and width != self.features.shape[1]:
            raise InputError(
                f"{self.name} was taught by {self.features.shape[1]} features, the network gives "
                f"{width}"
            )

    def distances(self, features: NDArray[np.floating]) -> NDArray[np.float64]:
        """Distances to the nearest example.

        Args:
            features: (m, f).

        Returns:
            (m,) 1 - cos of the angle, as in `NearExample`.
        """
        cosines = directions(features) @ directions(self.features).T
        return np.maximum(1.0 - cosines.max(axis=1), MIN_DISTANCE)

    def log_odds(
        self, distances: NDArray[np.float64], nearest_other: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Log-odds of belonging to the class.

        Args:
            distances: (m,) to the nearest example.
            nearest_other: (m,) to the nearest object of another class.

        Returns:
            (m,): slope · log(min(radius, nearest other) / distance), which is positive for objects
            of the class; `NOT_OF_IT` for others.
        """
        bound = np.minimum(self.radius, np.maximum(nearest_other, MIN_DISTANCE))
        nearness = np.log(bound / distances)
        return np.where(nearness > 0, self.slope * nearness, NOT_OF_IT)

    def to_dict(self) -> dict[str, Any]:
        """The class as JSON types; `from_dict` reads it."""
        features = [[float(f"{value:.6g}") for value in row] for row in self.features.tolist()]
        return {
            "name": self.name, "radius": self.radius, "slope": self.slope, "features": features,
        }  # fmt: skip

    @classmethod
    def from_dict(cls, document: Any) -> TaughtClass:
        """Read what `to_dict` returned.

        Raises:
            InputError: Not such a document.
        """
        if not isinstance(document, Mapping) or not isinstance(document.get("name"), str):
            raise InputError("a taught class needs a name")
        try:
            features = np.array(document.get("features"), np.float32)
        except (ValueError, TypeError) as error:
            raise InputError("features of a taught class must be rows of numbers") from error
        # Validated as all values are; None is no number.
        radius: Any = document.get("radius")
        slope: Any = document.get("slope")
        return cls(document["name"], features, radius, slope)


@dataclass(frozen=True, eq=False)
class TaughtClasses:
    """All taught classes of a classifier, in the order of its outputs.

    Attributes:
        classes: The classes.
        temperature: What the network's logits are divided by.
    """

    classes: Sequence[TaughtClass]
    temperature: float

    def completed(
        self,
        logits: NDArray[np.float64],
        features: NDArray[np.float64],
        nearest: NDArray[np.float64] | None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
        """Extend the answers of the network by the taught classes.

        Args:
            logits: (m, c) of the network.
            features: (m, f).
            nearest: (m,) distances to the nearest training object; None where they are unknown.

        Returns:
            (m, c + t) logits, and (m,) distances to the nearest training object or, of an object of
            a taught class, example.
        """
        scores = logits / self.temperature
        top = scores.max(axis=1)
        total = top + np.log(np.exp(scores - top[:, None]).sum(axis=1))
        known = np.full(len(logits), np.inf) if nearest is None else nearest
        to_each = np.stack([one.distances(features) for one in self.classes], axis=1)
        columns, closest = [logits], known
        for index, one in enumerate(self.classes):
            others = np.delete(to_each, index, axis=1).min(axis=1, initial=np.inf)
            odds = one.log_odds(to_each[:, index], np.minimum(known, others))
            columns.append(((total + odds) * self.temperature)[:, None])
            closest = np.where(odds > 0, np.minimum(closest, to_each[:, index]), closest)
        return np.concatenate(columns, axis=1), None if nearest is None else closest


def directions(features: NDArray[np.floating]) -> NDArray[np.float64]:
    """(n, f) features of length 1; zeros stay."""
    values = features.astype(np.float64)
    lengths = np.linalg.norm(values, axis=1, keepdims=True)
    return values / np.maximum(lengths, np.finfo(np.float64).tiny)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
