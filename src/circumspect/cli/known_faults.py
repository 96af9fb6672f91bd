"""Known faults as the command line tells them: one line that names the file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from circumspect.errors import CircumspectError


@contextmanager
def blamed_on(file: Path) -> Iterator[None]:
    """Put the file's name before the message of any known fault that lacks it."""
    try:
        yield
    except CircumspectError as error:
        if str(error).startswith(f"{file}:"):
            raise
        raise CircumspectError(f"{file}: {error}") from error
