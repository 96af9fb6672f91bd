"""Memory that the C library keeps though nobody uses it."""

from __future__ import annotations

import ctypes
from functools import lru_cache
from typing import Any


def give_back_heap() -> bool:
    """Return free pages of the heap to the system; where the C library has no such call, nothing.

    Tables of some hundred kB are replaced by slightly larger ones with every frame, so that a long
    run leaves holes in which the next ones do not fit: half an hour, 80 MB. It takes some ms.

    Returns:
        Whether anything was given back.
    """
    trim = _malloc_trim()
    return trim is not None and bool(trim(0))


@lru_cache(maxsize=1)
def _malloc_trim() -> Any:
    """The function of glibc; None elsewhere."""
    try:
        return ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):
        return None
