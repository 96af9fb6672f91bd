"""Limit and errors of files that other libraries read: E57, LAS and USD."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from circumspect.errors import InputError
from circumspect.geometry.formats.ignored_warnings import ignored_warnings

MAX_POINTS = 20_000_000
"""Largest number of points, since packed points may take little space in the file."""


def require_readable_count(count: int) -> None:
    """Check the number of points of a file.

    Raises:
        InputError: There are too many.
    """
    if count > MAX_POINTS:
        raise InputError(f"has {count} points; {MAX_POINTS} are read: thin it out first")


@contextmanager
def library_reading(kind: str) -> Iterator[None]:
    """Ignore warnings of a library, and convert its errors.

    Args:
        kind: Name of the file format.

    Raises:
        InputError: The library failed; the message has its reason.
    """
    try:
        with ignored_warnings():
            yield
    except (InputError, MemoryError, OSError):
        raise
    except Exception as error:  # Broken files bring about errors of several libraries.
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise InputError(f"is no readable {kind} file ({reason[:200]}); copy it again") from error
