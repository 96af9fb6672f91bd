"""What a classifier says of one object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.read_only_table import ReadOnlyTable


@dataclass(frozen=True)
class Prediction:
    """The class of one object; it can be compared, hashed, copied and pickled.

    Attributes:
        label: The most probable class.
        probability: Its probability, 0 … 1.
        probabilities: Class to probability, in the classifier's order; they sum to 1.
        milliseconds: Stage to time spent [ms]; not compared: the same answer may take longer.
        known: False where the object is less like anything that the classifier was trained on than
            nearly all objects of the classes: it may well be of none of them, and the label is the
            nearest guess.
        distance: To the nearest training object, see `NearExample`; None where the classifier's
            file does not hold them.
    """

    label: str
    probability: float
    probabilities: Mapping[str, float]
    milliseconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    known: bool = True
    distance: float | None = None

    def __post_init__(self) -> None:
        for name in ("probabilities", "milliseconds"):
            object.__setattr__(self, name, ReadOnlyTable(getattr(self, name)))

    def __repr__(self) -> str:
        known = "known" if self.known else "unknown"
        return f"Prediction({self.label} {self.probability:.2f}, {known})"

    def to_dict(self) -> dict[str, Any]:
        """The answer in JSON types, as `circumspect classify --json` prints it."""
        return {
            "label": self.label,
            "known": bool(self.known),
            "distance": None if self.distance is None else float(self.distance),
            "probability": float(self.probability),
            "probabilities": {name: float(p) for name, p in self.probabilities.items()},
            "milliseconds": {name: round(float(ms), 3) for name, ms in self.milliseconds.items()},
        }

    @property
    def doubt(self) -> str:
        """What a sentence about the answer ends with: nothing where it is `known`."""
        return "" if self.known else ", not sure to be of any class"

    @classmethod
    def from_probabilities(
        cls,
        classes: Sequence[str],
        probabilities: NDArray[np.floating],
        milliseconds: Mapping[str, float] | None = None,
        known: bool = True,
        distance: float | None = None,
    ) -> Prediction:
        """Build from a vector.

        Args:
            classes: The c class names.
            probabilities: (c,) that sum to 1.
            milliseconds: Stage to time spent [ms].
            known: Whether the object is like those that were trained on.
            distance: To the nearest of them.

        Raises:
            ValueError: There are not as many probabilities as classes, or none.
        """
        best = int(np.argmax(probabilities))
        named = {name: float(p) for name, p in zip(classes, probabilities, strict=True)}
        return cls(
            label=classes[best],
            probability=float(probabilities[best]),
            probabilities=named,
            milliseconds=milliseconds or {},
            known=known,
            distance=distance,
        )
