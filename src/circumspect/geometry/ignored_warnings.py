"""Warnings of other libraries ignored for a while, one thread at a time."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

# Reentrant, so that one reader may use another.
_ALONE = threading.RLock()


@contextmanager
def ignored_warnings() -> Iterator[None]:
    """Ignore all warnings; afterwards the filters are those of before.

    Filters belong to the whole process: two threads that change and restore them by turns can
    leave it with the changed ones. So this is the one place that changes them, and it lets one
    thread in at a time. They are never made errors, which would strike in every other thread.
    """
    with _ALONE, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
