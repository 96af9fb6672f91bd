"""Which fixes follow each other in time, whatever the cameras' clocks did."""

from __future__ import annotations

from collections.abc import Sequence

from circumspect.localization.space_fix import SpaceFix

LATE = "late"
"""Not later than one before: of images that came late, or of a clock that was set back."""
LEAP = "leap"
"""Without news, of images whose stamps all leapt ahead."""


def apart(fixes: Sequence[SpaceFix]) -> tuple[str | None, ...]:
    """Why each fix is part of no path: `LATE` or `LEAP`; None for those of the path.

    Args:
        fixes: In the order of arrival.
    """
    why: list[str | None] = []
    latest = -float("inf")
    for fix in fixes:
        if fix.stamp > latest:
            why.append(None)
            latest = fix.stamp
        else:
            why.append(LEAP if _leapt(fix) else LATE)
    return tuple(why)


def _leapt(fix: SpaceFix) -> bool:
    """Whether all of its images are of a later time than it tells of."""
    return bool(fix.sightings) and all(s.stamp > fix.stamp for s in fix.sightings)
