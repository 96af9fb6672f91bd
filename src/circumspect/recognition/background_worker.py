"""Work that nothing waits for yet, on another core."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait


class Aside:
    """Runs calls one after the other in a thread of its own, until they are waited for.

    What a call changes must not be looked at before `join`: then nothing depends on which of the
    two is faster.
    """

    def __init__(self) -> None:
        self._worker = ThreadPoolExecutor(1, "aside")
        self._begun: list[Future[None]] = []

    def begin(self, work: Callable[[], None]) -> None:
        """Have a call made as soon as those before it are done."""
        self._begun.append(self._worker.submit(work))

    def wait(self) -> None:
        """Wait for all that was begun; what failed is told by `join`.

        That may be more than is known of: an interrupt can come just after a call was handed over.
        """
        wait([self._worker.submit(_nothing)])

    def join(self) -> None:
        """Wait for all that was begun, and begin anew.

        Raises:
            Exception: The first that one of the calls raised; the others were made nevertheless.
        """
        self.wait()  # what is interrupted here is waited for by the next join
        begun, self._begun = self._begun, []
        for call in begun:
            call.result()


def _nothing() -> None:
    """The last in the row of calls."""
