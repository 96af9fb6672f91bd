"""Observers receive the result however a run ends."""

from __future__ import annotations

import pytest
from small_world import StepRecorder, frames, make_pipeline, run

from circumspect.recognition import RecognitionResult, run_pipeline


def test_ctrl_c_ends_the_run_after_its_observers_are_notified() -> None:
    def interrupted():
        yield from frames(2)
        raise KeyboardInterrupt

    recorder = StepRecorder()
    with pytest.raises(KeyboardInterrupt):
        run(interrupted(), recorder)
    assert recorder.ends[0].interrupted
    assert recorder.ends[0].prediction is not None
    assert len(recorder.steps) == 2


def test_ctrl_c_during_finalisation_notifies_observers(monkeypatch) -> None:
    recorder, pipeline = StepRecorder(), None

    def interrupted() -> bool:
        raise KeyboardInterrupt

    pipeline = make_pipeline()
    monkeypatch.setattr(pipeline, "finalise", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_pipeline(pipeline, frames(2), [recorder])
    assert recorder.ends[0].interrupted
    assert len(recorder.ends[0].steps) == 2


def test_an_observer_that_fails_at_the_end_does_not_affect_the_others() -> None:
    class Broken(StepRecorder):
        def on_end(self, result: RecognitionResult) -> None:
            super().on_end(result)
            raise OSError("no space left")

    broken, recorder = Broken(), StepRecorder()
    with pytest.raises(OSError, match="no space"):
        run(frames(2), broken, recorder)
    assert broken.ends == recorder.ends
    assert not recorder.ends[0].interrupted
