"""Temporarily ignore warnings of other libraries, one thread at a time."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

# Reentrant, since readers may use each other.
_ALONE = threading.RLock()


@contextmanager
def ignored_warnings() -> Iterator[None]:
    """Ignore all warnings, then restore the filters.

    Filters belong to the whole process: two threads that change and restore them alternately can
    leave the changed ones. So only this module changes them, and a lock admits one thread at a
    time. Warnings are never made errors, which would affect every other thread.
    """
    with _ALONE, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
