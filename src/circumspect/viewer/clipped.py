"""Numbers from a browser."""

from __future__ import annotations

from typing import Any


def clipped(value: Any, low: float, high: float) -> float:
    """A number within bounds, whatever came."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        return low
    return float(value)
