"""Memory that a process freed stays with it."""

from __future__ import annotations

import ctypes
import platform

# Of malloc.h.
_TRIM_THRESHOLD, _MMAP_MAX = -1, -4
_NEVER = 2**31 - 1


def keep_freed_memory() -> bool:
    """Have the C library keep what is freed for what comes next.

    Else glibc maps every array beyond 32 MB by itself and gives it back when it is freed: while a
    network is trained on a CPU the system spends its time on clearing the same gigabytes of pages
    again and again.

    Returns:
        Whether the C library could be told so; others than glibc can not.
    """
    if platform.libc_ver()[0] != "glibc":
        return False
    mallopt = ctypes.CDLL(None).mallopt
    return bool(mallopt(_MMAP_MAX, 0)) and bool(mallopt(_TRIM_THRESHOLD, _NEVER))
