"""What a classifier says of one object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.answer_text import answer_text
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.read_only_table import ReadOnlyTable

INSEPARABLE = 0.9
"""Classes that together have this probability, but not the first alone, are alternatives …"""
MOST_ALTERNATIVES = 3
"""… if they are no more than this …"""
LEAST_SHARE = 0.1
"""… and each has at least this probability."""
UNKNOWN_OBJECT = "the object is unlike the trained classes"


@dataclass(frozen=True)
class Prediction:
    """The class of one object; it can be compared, hashed, copied and pickled.

    Attributes:
        label: The most probable class.
        probability: Its probability, 0 … 1.
        probabilities: Class to probability, in the classifier's order; they sum to 1.
        milliseconds: Stage to time spent [ms]; not compared: the same answer may take longer.
        in_distribution: Whether the object resembles the trained classes; where it does not, the
            label is only the nearest class.
        distance: To the nearest training object, see `NearExample`; None where the classifier's
            file does not hold them.
        coverage: Share of the azimuth from which the object was seen, 0 … 1; None where unknown.
        rule: The bounds that make an answer confident.
        in_distribution_probability: Probability of being of one of the classes; None where the
            classifier's file has no such model.
        ambiguity: Why a probable answer is not confident, as where the object may stand on another
            face; empty as a rule.
    """

    label: str
    probability: float
    probabilities: Mapping[str, float]
    milliseconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    in_distribution: bool = True
    distance: float | None = None
    coverage: float | None = None
    rule: ConfidenceRule = field(default_factory=ConfidenceRule, repr=False)
    in_distribution_probability: float | None = None
    ambiguity: str = ""

    def __post_init__(self) -> None:
        for name in ("probabilities", "milliseconds"):
            object.__setattr__(self, name, ReadOnlyTable(getattr(self, name)))

    def __repr__(self) -> str:
        state = "" if self.in_distribution else ", unknown object"
        state += ", confident" if self.confident else ""
        return f"Prediction({self.label} {self.probability:.2f}{state})"

    @property
    def text(self) -> str:
        """The answer in words, such as "bathtub (96 %)"; see `answer_parts`."""
        return answer_text(self.label, self.probability, self.in_distribution, self.alternatives)

    @property
    def confident(self) -> bool:
        """Whether the answer may be acted on: in distribution, probable, enough coverage."""
        return not self.reason

    @property
    def reason(self) -> str:
        """Why the answer is not confident; empty where it is."""
        if not self.in_distribution:
            return UNKNOWN_OBJECT
        return self.rule.reason(self.probability, self.coverage) or self.ambiguity

    @property
    def alternatives(self) -> Mapping[str, float]:
        """Classes that shape and size do not separate, such as table and desk, most likely first.

        They include the label. Empty where the label alone has `INSEPARABLE` probability, where
        more than `MOST_ALTERNATIVES` classes would be needed, or for an unknown object. Classes of
        less than `LEAST_SHARE` are left out.
        """
        ranked = sorted(self.probabilities.items(), key=lambda item: -item[1])
        held = np.cumsum([share for _, share in ranked])
        count = int(np.searchsorted(held, INSEPARABLE)) + 1
        if not self.in_distribution or not 1 < count <= MOST_ALTERNATIVES:
            return ReadOnlyTable({})
        likely = {name: share for name, share in ranked[:count] if share >= LEAST_SHARE}
        return ReadOnlyTable(likely if len(likely) > 1 else {})

    def to_dict(self) -> dict[str, Any]:
        """The answer in JSON types, as `circumspect classify --json` prints it."""
        return {
            "label": self.label,
            "confident": self.confident,
            "reason": self.reason,
            "in_distribution": bool(self.in_distribution),
            "in_distribution_probability": _number(self.in_distribution_probability),
            "distance": _number(self.distance),
            "coverage": _number(self.coverage),
            "probability": float(self.probability),
            "probabilities": {name: float(p) for name, p in self.probabilities.items()},
            "alternatives": {name: float(p) for name, p in self.alternatives.items()},
            "milliseconds": {name: round(float(ms), 3) for name, ms in self.milliseconds.items()},
        }

    @classmethod
    def from_probabilities(
        cls,
        classes: Sequence[str],
        probabilities: NDArray[np.floating],
        milliseconds: Mapping[str, float] | None = None,
        **others: Any,
    ) -> Prediction:
        """Build from a vector.

        Args:
            classes: The c class names.
            probabilities: (c,) that sum to 1.
            milliseconds: Stage to time spent [ms].
            others: Further attributes.

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
            **others,
        )


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)
