"""What a browser sends is looked up or clipped; a run goes on when the last browser is closed."""

from __future__ import annotations

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from circumspect.classification import Classifier
from circumspect.robot import Operator
from circumspect.viewer import Dashboard
from circumspect.viewer.clipped import clipped
from circumspect.viewer.run_controls import LOST_SHARES, RunControls, RunRequest

FIRST = RunRequest("own.obj", 370.4, "circle")


@pytest.fixture(scope="module")
def dashboard():
    with Dashboard(Classifier.load(), port=0) as opened:
        yield opened


@pytest.fixture(scope="module")
def shown(dashboard):
    return RunControls(dashboard, ("chair", "sofa"), FIRST)


@pytest.fixture
def controls(shown):
    yield shown
    shown.release()
    shown.cover.value, shown.lose.value = False, "none"
    for control, value in ((shown.thing, "own.obj"), (shown.planner, "circle")):
        control._impl.value = value
    shown.start._impl.value = 10.0


def test_the_first_run_is_offered_too(controls):
    assert controls.wanted() == RunRequest("own.obj", 10.0, "circle")


@pytest.mark.parametrize("thing", ["../../etc/passwd", "", "__import__('os')", None, 7])
def test_an_object_that_was_not_offered_is_not_taken(controls, thing):
    controls.thing._impl.value = thing
    controls.planner._impl.value = thing
    controls.start._impl.value = thing
    assert controls.wanted().thing == "own.obj"
    assert controls.wanted().planner == "normals"
    assert controls.wanted().start_deg in (0.0, 7.0)


@pytest.mark.parametrize(
    ("value", "taken"),
    [(5, 5.0), (360.0, 360.0), (361.0, 0.0), (float("nan"), 0.0), ("5", 0.0), (True, 0.0)],
)
def test_numbers_are_clipped(value, taken):
    assert clipped(value, 0.0, 360.0) == taken


def test_what_was_set_before_a_run_begins_holds_for_it(controls):
    controls.cover.value, controls.lose.value = True, "30 %"
    operator = Operator()
    controls.take(operator)
    assert operator.covered
    assert operator.dropped == LOST_SHARES["30 %"]


def test_a_paused_run_goes_on_when_nobody_is_left(controls):
    operator = Operator()
    controls.take(operator)
    operator.pause()
    operator.cover(True)
    controls.let_go()
    assert not operator.paused
    assert not operator.covered
    controls.release()
    controls.let_go()
