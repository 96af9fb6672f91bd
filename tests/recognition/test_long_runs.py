"""What is done with every frame must not cost more in long runs."""

from __future__ import annotations

import dataclasses
import gc
import weakref

from small_world import frames, pipeline

from circumspect.recognition import FrameOutcome
from circumspect.reconstruction import view_density


def test_what_a_step_leaves_behind_is_freed_at_once() -> None:
    """Without the cycle collector, which rarely comes round to what was kept for long."""
    line = pipeline()
    shots = list(frames(5))
    line.step(shots[0])
    gc.collect()
    gc.disable()
    try:
        past = [weakref.ref(line.step(shot).model) for shot in shots[1:]]
        line.background.join()
        assert [model() is None for model in past] == [True, True, True, False]
        assert gc.collect() == 0
    finally:
        gc.enable()


def test_a_camera_that_stands_adds_no_noise_for_ever(monkeypatch) -> None:
    monkeypatch.setattr(view_density, "MAX_SIMILAR_VIEWS", 4)
    line = pipeline()
    shots = list(frames(6))
    standing = [dataclasses.replace(shots[0], stamp=float(stamp)) for stamp in range(6)]
    steps = [line.step(frame) for frame in standing]
    assert {step.outcome for step in steps} == {FrameOutcome.CLASSIFIED}
    assert [step.model.frames for step in steps] == [1, 2, 3, 4, 4, 4]
    assert all(step.prediction is not None for step in steps)
    # The camera continues from elsewhere.
    assert line.step(dataclasses.replace(shots[1], stamp=6.0)).model.frames == 5
