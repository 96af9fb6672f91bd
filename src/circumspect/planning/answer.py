"""The classifier's answer after a frame, as planners take it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Answer:
    """One of the answers of a run.

    Attributes:
        probabilities: Class to probability.
        coverage: Share of the azimuth seen until then, 0 … 1.
        in_distribution: Whether the object resembles the trained classes.
        confident: Whether the answer may be acted on, by the classifier's rule.
    """

    probabilities: Mapping[str, float]
    coverage: float
    in_distribution: bool = True
    confident: bool = False

    @property
    def label(self) -> str:
        """The most probable class."""
        return max(self.probabilities, key=lambda name: self.probabilities[name])
