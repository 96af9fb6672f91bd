"""Progress on standard error, with an estimate of the time left."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show a bar while the block runs.

    Args:
        what: What is being done.

    Yields:
        A function to call with (done, all).
    """
    with bars() as shown:
        task = shown.add_task(what, total=None, note="")
        yield lambda done, total: shown.update(task, completed=done, total=total)


def speaks() -> bool:
    """Whether this process tells the user: of those that torchrun starts, the first alone."""
    return os.environ.get("RANK", "0") == "0"


def bars() -> Progress:
    """Bars with a count and the time left; they vanish where nobody watches."""
    console = Console(stderr=True)
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
        console=console,
        disable=not (console.is_terminal and speaks()),
    )
