"""A place for the newest value: who puts never waits, who takes never gets an old one."""

from __future__ import annotations

import threading
from typing import Generic, TypeVar

T = TypeVar("T")


class NewestSlot(Generic[T]):
    """Holds at most one value; a value that nobody took is replaced."""

    def __init__(self) -> None:
        """Begin empty."""
        self._filled = threading.Condition()
        self._value: T | None = None
        self._new = self._closed = False

    @property
    def closed(self) -> bool:
        """Whether no more values are wanted."""
        return self._closed

    def put(self, value: T) -> None:
        """Replace what is there."""
        with self._filled:
            self._value, self._new = value, True
            self._filled.notify_all()

    def again(self) -> None:
        """Make the latest value new once more, if there was one."""
        with self._filled:
            self._new = self._value is not None
            self._filled.notify_all()

    def take(self, seconds: float | None = None) -> T | None:
        """The newest value, waiting for one; None where none came or the slot is closed."""
        with self._filled:
            self._filled.wait_for(lambda: self._new or self._closed, seconds)
            if self._closed or not self._new:
                return None
            self._new = False
            return self._value

    def close(self) -> None:
        """Let those who wait go."""
        with self._filled:
            self._closed = True
            self._filled.notify_all()
