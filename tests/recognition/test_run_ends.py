"""However a run ends, its observers are told what was gathered."""

from __future__ import annotations

import pytest
from small_world import Diary, frames, pipeline, run

from circumspect.recognition import RecognitionResult, run_pipeline


def test_ctrl_c_ends_the_run_after_its_observers_were_told() -> None:
    def interrupted():
        yield from frames(2)
        raise KeyboardInterrupt

    diary = Diary()
    with pytest.raises(KeyboardInterrupt):
        run(interrupted(), diary)
    assert diary.ends[0].interrupted
    assert diary.ends[0].prediction is not None
    assert len(diary.steps) == 2


def test_ctrl_c_while_the_end_is_worked_on_ends_the_run_as_well(monkeypatch) -> None:
    diary, line = Diary(), None

    def interrupted() -> bool:
        raise KeyboardInterrupt

    line = pipeline()
    monkeypatch.setattr(line, "finalise", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_pipeline(line, frames(2), [diary])
    assert diary.ends[0].interrupted
    assert len(diary.ends[0].steps) == 2


def test_an_observer_that_fails_at_the_end_keeps_nothing_from_the_others() -> None:
    class Broken(Diary):
        def on_end(self, result: RecognitionResult) -> None:
            super().on_end(result)
            raise OSError("no space left")

    broken, diary = Broken(), Diary()
    with pytest.raises(OSError, match="no space"):
        run(frames(2), broken, diary)
    assert broken.ends == diary.ends
    assert not diary.ends[0].interrupted
