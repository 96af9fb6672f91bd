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
from circumspect.geometry.ignored_warnings import ignored_warnings
from circumspect.geometry.number_table import read_table

WAIT = 10.0


def slow_lines(begun: threading.Event, go_on: threading.Event) -> Iterator[bytes]:
    begun.set()
    go_on.wait(WAIT)
    yield b"1 2 3\n"


def test_readers_that_overlap_leave_the_filters_as_they_were() -> None:
    """The first to come is the first to go: without a lock the second restores what that set."""
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


def test_a_reader_in_one_thread_makes_no_errors_of_warnings_in_others() -> None:
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


def test_one_within_another_does_not_wait_for_itself() -> None:
    with ignored_warnings(), ignored_warnings():
        warnings.warn("not heard", stacklevel=1)
    with pytest.warns(UserWarning, match="heard"):
        warnings.warn("heard", stacklevel=1)


def test_no_other_place_changes_the_filters() -> None:
    package = Path(circumspect.__file__).parent
    places = [file for file in package.rglob("*.py") if "catch_warnings" in file.read_text("utf-8")]
    assert [file.name for file in places] == ["ignored_warnings.py"]
