"""Setting of the C library to keep freed memory in the process."""

from __future__ import annotations

import ctypes
import platform

# Constants of malloc.h.
_TRIM_THRESHOLD, _MMAP_MAX = -1, -4
_NEVER = 2**31 - 1


def keep_freed_memory() -> bool:
    """Make the C library keep freed memory for later allocations.

    By default glibc maps every array above 32 MB separately and returns it to the system when it is
    freed. During training on a CPU the system then clears the same gigabytes of pages repeatedly.

    Returns:
        Whether the C library has this setting; only glibc has it.
    """
    if platform.libc_ver()[0] != "glibc":
        return False
    mallopt = ctypes.CDLL(None).mallopt
    return bool(mallopt(_MMAP_MAX, 0)) and bool(mallopt(_TRIM_THRESHOLD, _NEVER))
