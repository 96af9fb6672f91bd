"""A thread of its own that shows the newest state, so that a run never waits for a browser."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from circumspect.viewer.newest_slot import NewestSlot

T = TypeVar("T")
_log = logging.getLogger(__name__)

MOST_OFTEN = 25.0
"""Updates a second at most."""


class Publisher(Generic[T]):
    """Takes what is put into its slot and shows it, a few times a second at most.

    Attributes:
        slot: Where the newest state is put; `again` makes it shown once more.
        shown: How many states were shown.
        failure: Why the page could not be shown lately, if so; the run goes on without it.
    """

    def __init__(
        self,
        show: Callable[[T], None],
        watched: Callable[[], bool] = lambda: True,
        most_often: float = MOST_OFTEN,
    ) -> None:
        """Start the thread.

        Args:
            show: Shows a state; may take its time, and may fail.
            watched: Whether anybody looks; where nobody does, nothing is shown.
            most_often: States a second at most.
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
                # A page that fails is no reason for a robot to stop.
                if self.failure is None:
                    _log.warning("the page can not be shown: %s", error)
                self.failure = str(error)
            time.sleep(max(0.0, began + self._period - time.monotonic()))

    def close(self) -> None:
        """End the thread; a show that hangs is left behind."""
        self.slot.close()
        self._thread.join(timeout=1.0)
