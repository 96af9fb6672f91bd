"""Bounds the memory and the time of a block of a test."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def little_memory(most: int = 24 << 20, seconds: float = 10.0) -> Iterator[None]:
    """Fail if the block uses more bytes at once, or more processor time."""
    start = time.process_time()
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < most
        assert time.process_time() - start < seconds
    finally:
        tracemalloc.stop()
