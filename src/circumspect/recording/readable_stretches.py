"""Messages of a bag whose middle is damaged, by whatever reads them in the order of time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

Message = TypeVar("Message")

FIRST_STEP = 1_000_000
"""The search for the end of what is damaged begins with this step and doubles it [ns]."""
RESOLUTION = 10_000_000
"""It ends when the end is known to this [ns]."""


class ReadableStretches(Iterator[tuple[int, Message]]):
    """Iterates over messages; where reading fails it resumes at the next time that can be read.

    Attributes:
        gaps: How many stretches are damaged so far.
        lost: How long they are together [ns].
        error: Why reading failed last; None while it did not.
        broken_off: Whether nothing could be read after the last failure.
    """

    def __init__(self, read: Callable[[int], Iterator[tuple[int, Message]]], begin: int, end: int):
        """Begin to read.

        Args:
            read: Gives times and messages from a time on; it may raise anything.
            begin: Time of the first message [ns].
            end: Time after the last message [ns].
        """
        self._read, self._end = read, end
        self._found = read(begin)
        self._last = begin
        self.gaps = self.lost = 0
        self.error: Exception | None = None
        self.broken_off = False

    def __next__(self) -> tuple[int, Message]:
        while True:
            try:
                self._last, message = next(self._found)
            except StopIteration:
                raise
            except Exception as error:  # whatever a parser makes of a broken bag
                self.error = error
                self._skip()
                continue
            return self._last, message

    def _skip(self) -> None:
        before = self._last
        after = self._next_readable(before)
        if after is None:
            self.broken_off = True
            self._found = iter(())
            return
        self.gaps += 1
        self.lost += after - before
        self._found, self._last = self._read(after), after

    def _next_readable(self, last: int) -> int | None:
        failing, step = last, FIRST_STEP
        while failing < self._end:
            if self._is_readable(good := last + step):
                break
            failing, step = last + step, 2 * step
        else:
            return None
        while good - failing > RESOLUTION:
            middle = (failing + good) // 2
            if self._is_readable(middle):
                good = middle
            else:
                failing = middle
        return good

    def _is_readable(self, start: int) -> bool:
        try:
            next(self._read(start))
        except Exception:  # nothing is left, or see `__next__`
            return False
        return True
