"""Publisher thread that shows the newest state, so that a run never waits for a browser."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class NewestSlot(Generic[T]):
    """Holds at most one value; a newer value replaces one that was not taken."""

    def __init__(self) -> None:
        """Start empty."""
        self._filled = threading.Condition()
        self._value: T | None = None
        self._new = self._closed = False

    @property
    def closed(self) -> bool:
        """Whether the slot is closed."""
        return self._closed

    def put(self, value: T) -> None:
        """Replace the value."""
        with self._filled:
            self._value, self._new = value, True
            self._filled.notify_all()

    def again(self) -> None:
        """Put the latest value again, if there was one."""
        with self._filled:
            self._new = self._value is not None
            self._filled.notify_all()

    def take(self, seconds: float | None = None) -> T | None:
        """Wait for the newest value and take it; None after a timeout or if the slot is closed."""
        with self._filled:
            self._filled.wait_for(lambda: self._new or self._closed, seconds)
            if self._closed or not self._new:
                return None
            self._new = False
            return self._value

    def close(self) -> None:
        """Close the slot and wake waiting threads."""
        with self._filled:
            self._closed = True
            self._filled.notify_all()


_log = logging.getLogger(__name__)
MOST_OFTEN = 25.0
"""Maximum update rate [Hz]."""


class Publisher(Generic[T]):
    """Shows the newest state of its slot at a limited rate.

    Attributes:
        slot: Slot of the newest state; its `again` shows the state once more.
        shown: Number of shown states.
        failure: Why the page could not be shown, if so; the run continues without it.
    """

    def __init__(
        self,
        show: Callable[[T], None],
        watched: Callable[[], bool] = lambda: True,
        most_often: float = MOST_OFTEN,
    ) -> None:
        """Start the thread.

        Args:
            show: Shows a state; may be slow, and may fail.
            watched: Whether a browser is connected; otherwise nothing is shown.
            most_often: Maximum update rate [Hz].
        """
        self.slot: NewestSlot[T] = NewestSlot()
        self.shown = 0
        self.failure: str | None = None
        self._show, self._watched, self._period = show, watched, 1 / most_often
        self._thread = threading.Thread(target=self._work, name="dashboard", daemon=True)
        self._thread.start()

    def _work(self) -> None:
        while not self.slot.closed:
            state = self.slot.take()
            if state is None or not self._watched():
                continue
            began = time.monotonic()
            try:
                self._show(state)
                self.shown += 1
            except Exception as error:
                # A failing page must not stop the robot.
                if self.failure is None:
                    _log.warning("the page can not be shown: %s", error)
                self.failure = str(error)
            time.sleep(max(0.0, began + self._period - time.monotonic()))

    def close(self) -> None:
        """End the thread; a hanging `show` is abandoned."""
        self.slot.close()
        self._thread.join(timeout=1.0)
