"""What the object was called after a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

ENOUGH_SEEN = 0.75
"""An answer by a smaller share of the directions is not one to rely on: of 60 pieces of furniture
seen from half of them, 7 of 43 known answers of at least 0.9 were wrong, from three quarters 3 of
52 (`python -m benchmarks.scans --suite furniture`)."""


@dataclass(frozen=True, slots=True)
class Answer:
    """One of the answers on the way.

    Attributes:
        probabilities: Class to probability.
        seen: Share of the directions seen until then, 0 … 1.
        known: Whether the object was like any of the classes.
    """

    probabilities: Mapping[str, float]
    seen: float
    known: bool = True
