from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest
from scan_world import scan
from small_world import Inline, frames, make_pipeline

from circumspect.recognition import RecognitionPipeline, recognition_pipeline, run_pipeline
from circumspect.recognition.background_worker import BackgroundWorker
from circumspect.sensing import GroundSegmentation
from circumspect.tracking import KnownPoses, PoseEstimate, Tracker, TrackingState


def test_calls_run_in_order_in_the_background() -> None:
    worker, done, may_go_on = BackgroundWorker(), [], threading.Event()
    worker.submit(lambda: done.append(may_go_on.wait(60)))
    worker.submit(lambda: done.append("second"))
    assert done == []
    may_go_on.set()
    worker.join()
    assert done == [True, "second"]


def test_exception_is_raised_once_by_join() -> None:
    worker, done = BackgroundWorker(), []

    def fails() -> None:
        raise ValueError("a fault")

    worker.submit(fails)
    worker.submit(lambda: done.append("second"))
    with pytest.raises(ValueError, match="a fault"):
        worker.join()
    assert done == ["second"]
    worker.join()


class Busy(KnownPoses):
    """Every frame leaves pending work."""

    def __init__(self, state: TrackingState = TrackingState.TRACKING, fails_at: int = -1) -> None:
        self.state, self.fails_at = state, fails_at
        self.tracked, self.processed, self.threads = 0, 0, set[int]()

    def track(self, frame) -> PoseEstimate:
        assert self.processed == self.tracked
        self.tracked += 1
        return replace(super().track(frame), state=self.state)

    def process_pending(self) -> None:
        self.threads.add(threading.get_ident())
        if self.processed == self.fails_at:
            raise ValueError("a fault")
        self.processed += 1


def busy_pipeline(poses: Busy) -> RecognitionPipeline:
    parts = make_pipeline()
    return RecognitionPipeline(parts.segmentation, poses, parts.classifier)


@pytest.mark.parametrize("state", [TrackingState.TRACKING, TrackingState.LOST])
def test_pending_work_ends_in_another_thread_before_the_next_step(state: TrackingState) -> None:
    poses = Busy(state)
    pipeline = busy_pipeline(poses)
    for frame in frames(4):
        pipeline.step(frame)  # `Busy.track` checks that nothing is pending
    pipeline.finalise()
    assert poses.processed == 4
    assert threading.get_ident() not in poses.threads


def test_background_exception_ends_the_run_and_keeps_earlier_steps() -> None:
    pipeline, ends = busy_pipeline(Busy(fails_at=3)), []

    class Ends:
        def on_step(self, step) -> None:
            pass

        def on_end(self, result) -> None:
            ends.append(result)

    with pytest.raises(ValueError, match="a fault"):
        run_pipeline(pipeline, frames(6), (Ends(),))
    # It is raised by the frame after the one that left the work.
    assert len(ends[0].steps) == 4
    assert ends[0].interrupted


@pytest.mark.parametrize("fails_at", [-1, 0])
def test_interrupted_step_waits_for_background_work(fails_at: int, monkeypatch) -> None:
    """The interrupt propagates, even if the background work fails."""
    poses = Busy(fails_at=fails_at)
    pipeline, shots = busy_pipeline(poses), list(frames(2))

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(GroundSegmentation, "object_mask", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_pipeline(pipeline, shots)
    assert poses.processed == (0 if fails_at == 0 else 1)
    assert poses.tracked == 1


def test_step_waits_for_background_work_of_an_interrupted_step(monkeypatch) -> None:
    class Slow(Busy):
        def process_pending(self) -> None:
            threading.Event().wait(0.3)
            super().process_pending()

    poses = Slow()
    pipeline, (first, second, third) = busy_pipeline(poses), frames(3)
    pipeline.step(first)
    join = BackgroundWorker.join

    def interrupted(self: BackgroundWorker) -> None:
        monkeypatch.setattr(BackgroundWorker, "join", join)
        raise KeyboardInterrupt

    monkeypatch.setattr(BackgroundWorker, "join", interrupted)
    with pytest.raises(KeyboardInterrupt):
        pipeline.step(second)
    pipeline.step(third)
    pipeline.finalise()
    assert (poses.tracked, poses.processed) == (2, 2)


def test_background_work_does_not_change_the_results(monkeypatch) -> None:
    """Poses, model and answer of a robot that drives round a box and closes its loop."""
    results = []
    for worker in (BackgroundWorker, Inline):
        monkeypatch.setattr(recognition_pipeline, "BackgroundWorker", worker)
        object_scan = scan(poses=Tracker())
        results.append((object_scan.run(), object_scan.pipeline.tracker.corrections))
    (one, corrections), (other, also) = results
    assert corrections == also > 0
    for a, b in zip(one.steps, other.steps, strict=True):
        assert (a.outcome, a.coverage, a.prediction) == (b.outcome, b.coverage, b.prediction)
        places = [step.pose.T_map_camera.as_matrix() for step in (a, b)]
        np.testing.assert_array_equal(*places)
        np.testing.assert_array_equal(a.pose.covariance, b.pose.covariance)
    np.testing.assert_array_equal(one.last.model.sums.totals, other.last.model.sums.totals)
    np.testing.assert_array_equal(one.last.grid.states, other.last.grid.states)


def test_time_of_the_join_counts_as_registration() -> None:
    class Slow(Busy):
        def process_pending(self) -> None:
            threading.Event().wait(0.3)
            super().process_pending()

    pipeline = busy_pipeline(Slow(TrackingState.LOST))
    _, step = map(pipeline.step, frames(2))
    assert step.milliseconds["register"] > 250
    assert np.isclose(sum(step.milliseconds.values()), step.milliseconds["register"])
