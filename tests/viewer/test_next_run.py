"""Requests of a browser are validated or clipped."""

from __future__ import annotations

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from circumspect.classification import Classifier
from circumspect.viewer import Dashboard
from circumspect.viewer.guarded_server import clipped
from circumspect.viewer.next_run import NextRun, RunRequest
from circumspect.viewer.run_controls import RunControls

FIRST = RunRequest("own.obj", 370.4, "circle")


@pytest.fixture
def tab():
    with Dashboard(Classifier.load(), port=0) as dashboard:
        yield NextRun(dashboard, RunControls(dashboard), ("chair", "sofa"), FIRST)


def test_the_first_run_is_among_the_choices(tab):
    assert tab.wanted() == RunRequest("own.obj", 10.0, "circle")


@pytest.mark.parametrize("value", ["../../etc/passwd", "", "__import__('os')", None, 7])
def test_invalid_choices_fall_back_to_valid_ones(tab, value):
    tab.object_name._impl.value = value
    tab.planner._impl.value = value
    tab.start._impl.value = value
    assert tab.wanted().object_name == "own.obj"
    assert tab.wanted().planner == "normals"
    assert tab.wanted().start_deg in (0.0, 7.0)


@pytest.mark.parametrize(
    ("value", "taken"),
    [(5, 5.0), (360.0, 360.0), (361.0, 0.0), (float("nan"), 0.0), ("5", 0.0), (True, 0.0)],
)
def test_numbers_are_clipped(value, taken):
    assert clipped(value, 0.0, 360.0) == taken
