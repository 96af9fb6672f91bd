"""Settings hold for the next run; a run resumes when the last browser is closed."""

from __future__ import annotations

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from circumspect.classification import Classifier
from circumspect.robot import Operator
from circumspect.viewer import Dashboard
from circumspect.viewer.run_controls import LOST_SHARES, RunControls


@pytest.fixture(scope="module")
def dashboard():
    with Dashboard(Classifier.load(), port=0) as opened:
        yield opened


@pytest.fixture(scope="module")
def shown(dashboard):
    return RunControls(dashboard)


@pytest.fixture
def controls(shown):
    yield shown
    shown.release()
    shown.cover.value, shown.lose.value = False, "none"


def test_settings_made_before_a_run_apply_to_it(controls):
    controls.cover.value, controls.lose.value = True, "30 %"
    operator = Operator()
    controls.take(operator)
    assert operator.covered
    assert operator.dropped == LOST_SHARES["30 %"]


def test_a_paused_run_resumes_when_the_last_browser_is_closed(controls):
    operator = Operator()
    controls.take(operator)
    operator.pause()
    operator.cover(True)
    controls.let_go()
    assert not operator.paused
    assert not operator.covered
    controls.release()
    controls.let_go()


def test_pause_is_disabled_without_a_run(controls):
    with Dashboard(Classifier.load(), port=0) as fresh:
        before = RunControls(fresh)
        assert before.pause.disabled
        assert before.step.disabled
    controls.take(Operator())
    assert not controls.pause.disabled
    assert not controls.step.disabled
    controls.release()
    assert controls.pause.disabled
    assert controls.step.disabled
