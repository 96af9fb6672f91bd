"""Rate limit for repeated warnings: the first is logged, the others are counted."""

from __future__ import annotations

import logging
import re

MAX_KINDS = 200
"""Maximum number of kinds that are counted separately; further kinds share one counter."""
_NUMBERS = re.compile(r"\d+(\.\d+)?")


class RepeatedWarnings:
    """Logs the first warning of each kind; warnings that differ only in numbers are one kind."""

    def __init__(self, log: logging.Logger) -> None:
        """Start with empty counters.

        Args:
            log: Receives the warnings.
        """
        self._log = log
        self._counts: dict[str, tuple[str, int]] = {}

    def warn(self, text: str) -> None:
        """Log a warning, or count it if one of its kind was logged before."""
        kind = _NUMBERS.sub("#", text)
        if kind not in self._counts and len(self._counts) >= MAX_KINDS:
            kind = ""
        first, count = self._counts.get(kind, (text, 0))
        self._counts[kind] = first, count + 1
        if count == 0:
            self._log.warning("%s", text)

    def log_counts(self) -> None:
        """Log the number of each repeated warning, and reset the counters."""
        for first, count in self._counts.values():
            if count > 1:
                self._log.warning("%s (%d times like this)", first, count)
        self._counts.clear()
