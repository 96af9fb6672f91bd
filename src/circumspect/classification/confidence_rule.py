"""When an answer may be acted on: a bound on the probability for each coverage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

from circumspect.classification.answer_text import percent
from circumspect.errors import InputError


@dataclass(frozen=True)
class ConfidenceRule:
    """The smallest probability of a confident answer, as a step function of the coverage.

    The default is 75 % coverage and a probability of 0.9. A classifier's file may hold its own
    bounds, fitted to held-back objects (`circumspect calibrate`).

    Attributes:
        coverage: Ascending fractions of the azimuth, 0 … 1, at which each bound begins.
        probability: The bound from each coverage on; above 1 no answer is confident.
        without_coverage: The bound where the coverage is unknown, as for a file.

    Raises:
        InputError: Bounds that are not numbers, not ascending in coverage, or not as many.
    """

    coverage: tuple[float, ...] = (0.75,)
    probability: tuple[float, ...] = (0.9,)
    without_coverage: float = 0.9

    def __post_init__(self) -> None:
        numbers = (*self.coverage, *self.probability, self.without_coverage)
        if not all(_is_share(value, 2.0) for value in numbers):
            raise InputError(f"bounds of confidence must lie in 0 … 2, not {numbers!r:.80}")
        if len(self.coverage) != len(self.probability) or not self.coverage:
            raise InputError("a bound of confidence needs one coverage and one probability each")
        if any(b <= a for a, b in zip(self.coverage, self.coverage[1:], strict=False)):
            raise InputError(f"coverages must ascend: {self.coverage!r:.80}")

    def bound(self, coverage: float | None) -> float | None:
        """The smallest probability of a confident answer.

        Args:
            coverage: Share of the azimuth seen, 0 … 1; None where that is unknown.

        Returns:
            The bound; None where the coverage is too small for any.
        """
        if coverage is None:
            return self.without_coverage
        held = [p for c, p in zip(self.coverage, self.probability, strict=True) if coverage >= c]
        return held[-1] if held else None

    def reason(self, probability: float, coverage: float | None) -> str:
        """Reason why an answer is not confident; empty if it is."""
        bound = self.bound(coverage)
        if bound is None:
            return f"at least {percent(self.coverage[0])} coverage is needed"
        if probability >= bound:
            return ""
        if bound > 1.0:
            return "more coverage is needed"
        return f"a probability of at least {_just_above(bound, probability)} is needed"

    def to_dict(self) -> dict[str, Any]:
        """The rule as JSON types; `from_dict` reads it."""
        return {
            "coverage": list(self.coverage),
            "probability": list(self.probability),
            "without_coverage": self.without_coverage,
        }

    @classmethod
    def from_dict(cls, document: Any) -> ConfidenceRule:
        """Read what `to_dict` returned; None stands for the default.

        Raises:
            InputError: Not such a document.
        """
        if document is None:
            return cls()
        if not isinstance(document, Mapping) or set(document) != set(cls().to_dict()):
            raise InputError(f"the rule of confidence must be an object, not {document!r:.60}")
        rows = document["coverage"], document["probability"]
        if not all(isinstance(row, list) and len(row) <= MAX_BOUNDS for row in rows):
            raise InputError("the rule of confidence needs two lists of numbers")
        return cls(tuple(rows[0]), tuple(rows[1]), document["without_coverage"])


def _just_above(bound: float, probability: float) -> str:
    """The bound; with the probability below it if both would be printed alike."""
    if percent(bound) != percent(probability):
        return percent(bound)
    # Rounded apart, so that they differ however near they are.
    return f"{ceil(1e4 * bound) / 100:.2f} % instead of {floor(1e4 * probability) / 100:.2f} %"


MAX_BOUNDS = 100


def _is_share(value: Any, most: float) -> bool:
    return not isinstance(value, bool) and isinstance(value, int | float) and 0 <= value <= most
