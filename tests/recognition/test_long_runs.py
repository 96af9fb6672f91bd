"""Memory and noise are bounded in long runs."""

from __future__ import annotations

import dataclasses
import gc
import weakref

from small_world import frames, make_pipeline

from circumspect.recognition import FrameOutcome
from circumspect.reconstruction import view_density


def test_models_of_earlier_steps_are_freed_at_once() -> None:
    """Without the cycle collector, which rarely visits old objects."""
    pipeline = make_pipeline()
    shots = list(frames(5))
    pipeline.step(shots[0])
    gc.collect()
    gc.disable()
    try:
        past = [weakref.ref(pipeline.step(shot).model) for shot in shots[1:]]
        pipeline.background.join()
        assert [model() is None for model in past] == [True, True, True, False]
        assert gc.collect() == 0
    finally:
        gc.enable()


def test_a_standing_camera_adds_a_bounded_number_of_frames(monkeypatch) -> None:
    monkeypatch.setattr(view_density, "MAX_SIMILAR_VIEWS", 4)
    pipeline = make_pipeline()
    shots = list(frames(6))
    standing = [dataclasses.replace(shots[0], stamp=float(stamp)) for stamp in range(6)]
    steps = [pipeline.step(frame) for frame in standing]
    assert {step.outcome for step in steps} == {FrameOutcome.CLASSIFIED}
    assert [step.model.frames for step in steps] == [1, 2, 3, 4, 4, 4]
    assert all(step.prediction is not None for step in steps)
    # The camera continues from elsewhere.
    assert pipeline.step(dataclasses.replace(shots[1], stamp=6.0)).model.frames == 5
