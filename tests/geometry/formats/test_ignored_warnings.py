"""Warning filters belong to the process: readers in threads leave them as they were."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import circumspect
from circumspect.geometry.formats.ignored_warnings import ignored_warnings
from circumspect.geometry.formats.number_table import read_table

WAIT = 10.0


def slow_lines(begun: threading.Event, go_on: threading.Event) -> Iterator[bytes]:
    begun.set()
    go_on.wait(WAIT)
    yield b"1 2 3\n"


def test_concurrent_readers_restore_the_filters() -> None:
    """Without a lock, the second reader would restore the filters that the first one set."""
    before = list(warnings.filters)
    begun, go_on = [threading.Event() for _ in range(2)], [threading.Event() for _ in range(2)]
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(read_table, slow_lines(begun[0], go_on[0]))
        assert begun[0].wait(WAIT)
        second = pool.submit(read_table, slow_lines(begun[1], go_on[1]))
        # Without a lock the second is inside now, too.
        begun[1].wait(0.2)
        go_on[0].set()
        np.testing.assert_array_equal(first.result(WAIT), [[1, 2, 3]])
        go_on[1].set()
        np.testing.assert_array_equal(second.result(WAIT), [[1, 2, 3]])
    assert warnings.filters == before


def test_a_reader_does_not_turn_warnings_of_other_threads_into_errors() -> None:
    begun, go_on = threading.Event(), threading.Event()
    with warnings.catch_warnings(), ThreadPoolExecutor(1) as pool:
        warnings.simplefilter("default")
        reading = pool.submit(read_table, slow_lines(begun, go_on))
        assert begun.wait(WAIT)
        try:
            warnings.warn("said meanwhile", stacklevel=1)
        finally:
            go_on.set()
        reading.result(WAIT)


def test_nested_use_does_not_deadlock() -> None:
    with ignored_warnings(), ignored_warnings():
        warnings.warn("ignored", stacklevel=1)
    with pytest.warns(UserWarning, match="raised"):
        warnings.warn("raised", stacklevel=1)


def test_no_other_module_changes_the_filters() -> None:
    package = Path(circumspect.__file__).parent
    places = [file for file in package.rglob("*.py") if "catch_warnings" in file.read_text("utf-8")]
    assert [file.name for file in places] == ["ignored_warnings.py"]
