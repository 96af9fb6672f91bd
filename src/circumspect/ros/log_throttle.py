"""Rate limit of repeated log messages."""

from __future__ import annotations

import logging
import re
import time
from collections import OrderedDict
from collections.abc import Callable

MAX_KINDS = 200
"""Maximum number of message kinds that are remembered."""
_NUMBERS = re.compile(r"\d+")


class LogThrottle(logging.Filter):
    """Passes each kind of message once per interval and reports how many were suppressed.

    Messages of a logger that differ only in numbers, such as stamps, are one kind.
    """

    def __init__(self, seconds: float = 5.0, clock: Callable[[], float] = time.monotonic) -> None:
        """Start without history.

        Args:
            seconds: Interval between two messages of a kind [s].
            clock: Current time [s].
        """
        super().__init__()
        self._seconds, self._clock = seconds, clock
        self._logged: OrderedDict[tuple[str, str], tuple[float, int]] = OrderedDict()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a message is logged."""
        kind = record.name, _NUMBERS.sub("#", record.getMessage())
        now = self._clock()
        before, suppressed = self._logged.get(kind, (-float("inf"), 0))
        if now - before < self._seconds:
            self._logged[kind] = before, suppressed + 1
            return False
        self._logged[kind] = now, 0
        self._logged.move_to_end(kind)
        if len(self._logged) > MAX_KINDS:
            self._logged.popitem(last=False)
        if suppressed:
            record.msg = f"{record.getMessage()} (and {suppressed} more like this)"
            record.args = ()
        return True
