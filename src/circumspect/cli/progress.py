"""Progress on standard error with the estimated remaining time."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import (
    BarColumn,
    DownloadColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)

from circumspect.cli.console import OutputConsole
from circumspect.cli.say import say

PRINT_EVERY_S = 60.0
"""Time between two lines of a log [s]."""


@contextmanager
def progress_bar(what: str, of_bytes: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Show a bar while the block runs, or print lines at intervals without a terminal.

    Args:
        what: Description of the work.
        of_bytes: Whether counts are bytes; they are printed in MB.

    Yields:
        A function to call with (done, all).
    """
    with bars(of_bytes) as shown:
        if shown.disable:
            yield _Lines(what, of_bytes) if speaks() else _silent
            return
        # The bar stays hidden if the work is already done.
        task = shown.add_task(what, total=None, note="", visible=False)
        yield lambda done, total: shown.update(task, completed=done, total=total, visible=True)


class _Lines:
    """Prints lines of progress for a log."""

    def __init__(self, what: str, of_bytes: bool) -> None:
        self._what, self._of_bytes = what, of_bytes
        self._begin: tuple[float, int] | None = None
        self._printed = 0.0

    def __call__(self, done: int, total: int) -> None:
        now = time.monotonic()
        if self._begin is None:
            self._begin, self._printed = (now, done), now
        begin, before = self._begin
        if now - self._printed < PRINT_EVERY_S or done == before:
            return
        self._printed = now
        left = (now - begin) * (total - done) / (done - before)
        count = (
            f"{done / 1e6:.0f} of {total / 1e6:.0f} MB" if self._of_bytes else f"{done} of {total}"
        )
        say(f"{self._what}: {count}, {_duration(left)} left")


def _duration(seconds: float) -> str:
    minutes = round(seconds / 60)
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes} min"


def _silent(done: int, total: int) -> None:
    """Print nothing; another process prints the progress."""


def speaks() -> bool:
    """Whether this process prints; with torchrun only the first one does."""
    return os.environ.get("RANK", "0") == "0"


def bars(of_bytes: bool = False) -> Progress:
    """Bars with a count and the remaining time, disabled without a terminal.

    Args:
        of_bytes: See `progress_bar`.
    """
    console = OutputConsole(stderr=True)
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        DownloadColumn() if of_bytes else MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
        console=console,
        disable=not (console.is_terminal and speaks()),
    )
