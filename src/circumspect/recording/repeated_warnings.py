"""Warnings that may come with every message: the first is logged, the others are counted."""

from __future__ import annotations

import logging
import re

MAX_KINDS = 200
"""Kinds of warnings that are counted each by itself; further ones are counted together."""
_NUMBERS = re.compile(r"\d+(\.\d+)?")


class RepeatedWarnings:
    """Logs the first warning of each kind; warnings that differ in numbers alone are of a kind."""

    def __init__(self, log: logging.Logger) -> None:
        """Begin with nothing logged.

        Args:
            log: Takes the warnings.
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
        """Log how often each repeated warning came, and forget them."""
        for first, count in self._counts.values():
            if count > 1:
                self._log.warning("%s (%d times like this)", first, count)
        self._counts.clear()
