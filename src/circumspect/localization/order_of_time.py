"""Which fixes follow each other in time, whatever the cameras' clocks did."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from circumspect.localization.space_fix import SpaceFix

LATE = "late"
"""Without news, of images that all came late."""
LEAP = "leap"
"""Without news, of images whose stamps all leapt ahead."""
SET_BACK = "set back"
"""Of a time that was told twice, as a clock was set back, by the clock that knew fewer poses."""


def apart(fixes: Sequence[SpaceFix]) -> tuple[str | None, ...]:
    """Why each fix is part of no path: `LATE`, `LEAP` or `SET_BACK`; None for those of the path.

    Args:
        fixes: In the order of arrival.
    """
    why: list[str | None] = [None] * len(fixes)
    stretches: list[list[int]] = []
    before = float("inf")
    for number, fix in enumerate(fixes):
        if fix.stamp == before:
            why[number] = LEAP if _leapt(fix) else LATE
        elif fix.stamp > before:
            stretches[-1].append(number)
        else:
            stretches.append([number])
        before = fix.stamp
    for number in _told_twice(fixes, stretches):
        why[number] = SET_BACK
    return tuple(why)


def _told_twice(fixes: Sequence[SpaceFix], stretches: Iterable[list[int]]) -> list[int]:
    """What has to be left out of stretches with a clock of their own each, to make one path."""
    path: list[int] = []
    left_out: list[int] = []
    for stretch in stretches:
        begin = fixes[stretch[0]].stamp
        end = fixes[path[-1]].stamp if path else -float("inf")
        # The times that both tell of.
        old = [number for number in path if fixes[number].stamp >= begin]
        new = [number for number in stretch if fixes[number].stamp <= end]
        if _poses(fixes, new) > _poses(fixes, old):
            left_out += old
            path = [*path[: len(path) - len(old)], *stretch]
        else:
            left_out += new
            path += stretch[len(new) :]
    return left_out


def _poses(fixes: Sequence[SpaceFix], numbers: Iterable[int]) -> int:
    return sum(fixes[number].T_map_base is not None for number in numbers)


def _leapt(fix: SpaceFix) -> bool:
    """Whether all of its images are of a later time than it tells of."""
    return bool(fix.sightings) and all(s.stamp > fix.stamp for s in fix.sightings)
