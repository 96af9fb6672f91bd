"""Pairs of keyframes that wait for being fitted to each other."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from circumspect.mapping.keyframe_pairs import AGES, closes_a_loop, is_consecutive

CROWDED = 2 * (1 + len(AGES))
"""More pairs than two keyframes bring: they come faster than frames that leave time for them."""


class PairQueue:
    """First come, first served; in a hurry, what a correction needs comes first."""

    def __init__(self) -> None:
        """Nothing waits."""
        self._pairs: deque[tuple[int, int]] = deque()

    def __len__(self) -> int:
        return len(self._pairs)

    @property
    def is_crowded(self) -> bool:
        """Whether keyframes come too fast."""
        return len(self) > CROWDED

    @property
    def holds_up(self) -> bool:
        """Whether a pair waits that a correction needs: of the chain, or one that closes a loop."""
        return any(_rank(pair) < 2 for pair in self._pairs)

    def put(self, pairs: Iterable[tuple[int, int]]) -> None:
        """Let pairs of numbers wait, too."""
        self._pairs.extend(pairs)

    def take(self, hurry: bool = False) -> tuple[int, int]:
        """The next pair; it waits no longer.

        Args:
            hurry: Rather one that a correction needs.

        Raises:
            IndexError: Nothing waits.
        """
        if not hurry or not self._pairs:
            return self._pairs.popleft()
        pair = min(self._pairs, key=_rank)
        self._pairs.remove(pair)
        return pair

    def take_out(self, number: int) -> list[tuple[int, int]]:
        """All pairs of a keyframe; they wait no longer."""
        taken = [pair for pair in self._pairs if number in pair]
        self._pairs = deque(pair for pair in self._pairs if number not in pair)
        return taken


def _rank(pair: tuple[int, int]) -> int:
    """What comes first: a loop that is closed where the chain has a gap would bend the rest."""
    if is_consecutive(*pair):
        return 0
    return 1 if closes_a_loop(*pair) else 2
