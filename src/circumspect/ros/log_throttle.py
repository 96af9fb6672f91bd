"""The same fault again and again is one line now and then."""

from __future__ import annotations

import logging
import re
import time
from collections import OrderedDict
from collections.abc import Callable

MOST = 200
"""Kinds of lines that are remembered."""
_NUMBERS = re.compile(r"\d+")


class LogThrottle(logging.Filter):
    """Lets each kind of line through once in a while; says how many were held back.

    Lines of a logger that differ in numbers alone, such as stamps, are of a kind.
    """

    def __init__(self, seconds: float = 5.0, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin with nothing said.

        Args:
            seconds: Between two lines of a kind [s].
            clock: Gives the time [s].
        """
        super().__init__()
        self._seconds, self._clock = seconds, clock
        self._said: OrderedDict[tuple[str, str], tuple[float, int]] = OrderedDict()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a line is to be said."""
        kind = record.name, _NUMBERS.sub("#", record.getMessage())
        now = self._clock()
        before, held = self._said.get(kind, (-float("inf"), 0))
        if now - before < self._seconds:
            self._said[kind] = before, held + 1
            return False
        self._said[kind] = now, 0
        self._said.move_to_end(kind)
        if len(self._said) > MOST:
            self._said.popitem(last=False)
        if held:
            record.msg = f"{record.getMessage()} (and {held} more like this)"
            record.args = ()
        return True
