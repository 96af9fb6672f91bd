from __future__ import annotations

import ctypes
import sys

import pytest
from small_world import frames, pipeline

from circumspect.pipeline import heap, recognition_pipeline


def test_free_memory_goes_back_where_the_c_library_can() -> None:
    known = sys.platform == "linux" and hasattr(ctypes.CDLL(None), "malloc_trim")
    assert (heap._malloc_trim() is not None) is known
    assert heap.give_back_heap() in ((True, False) if known else (False,))


def test_another_c_library_keeps_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> None:
        raise OSError("no such library")

    monkeypatch.setattr(heap.ctypes, "CDLL", none)
    heap._malloc_trim.cache_clear()
    try:
        assert heap.give_back_heap() is False
    finally:
        heap._malloc_trim.cache_clear()


def test_a_long_run_gives_back_now_and_then(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[int] = []
    monkeypatch.setattr(recognition_pipeline, "TRIM_EVERY", 3)
    monkeypatch.setattr(recognition_pipeline, "give_back_heap", lambda: given.append(1))
    result = pipeline().run(frames(7))
    assert len(result.steps) == 7
    assert len(given) == 2
