"""How long the stages of a run took."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from circumspect.runs.run_folder import stage_lists, stage_times

STEPS = [
    SimpleNamespace(milliseconds={"register": 10.0, "fuse": 2.0}),
    SimpleNamespace(milliseconds={}),
    SimpleNamespace(milliseconds={"register": 30.0}),
]


def test_a_frame_is_the_sum_of_its_stages() -> None:
    assert stage_lists(STEPS) == {"register": [10, 30], "fuse": [2], "frame": [12, 30]}


def test_planning_is_added_to_the_frame_before_it() -> None:
    times = stage_lists(STEPS, [5.0, 1.0])
    assert times["plan"] == [5, 1]
    assert times["frame"] == [17, 1, 30], "planning follows unused frames, too"


def test_times_are_summarised_as_median_and_percentile() -> None:
    assert stage_times(STEPS)["register"] == {"median": 20, "p95": pytest.approx(29)}
    assert stage_times([]) == {}
