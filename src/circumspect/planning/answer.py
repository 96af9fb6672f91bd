"""What the object was called after a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

ENOUGH_SEEN = 0.5
"""An answer by a smaller share of the directions is not one to rely on."""


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
