"""How far a share can be trusted that was counted on a few objects."""

from __future__ import annotations

from math import sqrt

NORMAL_95 = 1.959964
"""The standard normal distribution lies within plus and minus this with 95 % probability."""


def wilson_interval(hits: int, count: int) -> tuple[float, float]:
    """The 95 % interval of a share (Wilson, "Probable inference", JASA 1927).

    It assumes independent objects. Unlike the share plus and minus its standard error it stays
    within 0 … 1, and has a width where all or none are hits.

    Args:
        hits: How many of the objects.
        count: How many objects; at least 1.

    Raises:
        ValueError: `hits` does not lie in 0 … `count`, or there are no objects.
    """
    if not 0 <= hits <= count or not count:
        raise ValueError(f"{hits} of {count} objects is no share")
    z2 = NORMAL_95**2 / count
    middle = (hits / count + z2 / 2) / (1 + z2)
    half = sqrt(z2 * (hits / count * (1 - hits / count) + z2 / 4)) / (1 + z2)
    # Rounding must not leave an interval that excludes a share of 0 or 1.
    low = 0.0 if hits == 0 else max(0.0, middle - half)
    high = 1.0 if hits == count else min(1.0, middle + half)
    return low, high
