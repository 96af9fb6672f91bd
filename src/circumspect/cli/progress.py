"""Progress on standard error, with an estimate of the time left."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    DownloadColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)


@contextmanager
def progress_bar(what: str, of_bytes: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Show a bar while the block runs.

    Args:
        what: What is being done.
        of_bytes: What is counted are bytes, and told as MB.

    Yields:
        A function to call with (done, all).
    """
    with bars(of_bytes) as shown:
        # What turns out to be there already shows no bar at all.
        task = shown.add_task(what, total=None, note="", visible=False)
        yield lambda done, total: shown.update(task, completed=done, total=total, visible=True)


def speaks() -> bool:
    """Whether this process tells the user: of those that torchrun starts, the first alone."""
    return os.environ.get("RANK", "0") == "0"


def bars(of_bytes: bool = False) -> Progress:
    """Bars with a count and the time left; they vanish where nobody watches.

    Args:
        of_bytes: See `progress_bar`.
    """
    console = Console(stderr=True)
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        DownloadColumn() if of_bytes else MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
        console=console,
        disable=not (console.is_terminal and speaks()),
    )
