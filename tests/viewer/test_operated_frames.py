"""Recorded frames obey an operator, and give the frame in progress."""

from __future__ import annotations

import threading

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")

from circumspect.geometry import PinholeCamera
from circumspect.robot import Operator, RunStopped
from circumspect.sensing import RgbdFrame
from circumspect.viewer.run_controls import OperatedFrames

CAMERA = PinholeCamera(4, 3, 4.0, 4.0, 1.5, 1.0)
FRAMES = [RgbdFrame(np.ones((3, 4), np.float32), CAMERA, float(stamp)) for stamp in range(200)]


def test_the_frame_in_progress_is_available():
    frames = OperatedFrames(FRAMES, Operator())
    assert frames.frame is None
    for frame in frames:
        assert frames.frame is frame
        assert frames.ended is None
    assert frames.ended == "the end of the recording"


def test_a_covered_camera_sees_nothing():
    operator = Operator()
    operator.cover(True)
    assert not any(frame.valid.any() for frame in OperatedFrames(FRAMES[:3], operator))


def test_the_same_seed_drops_the_same_frames():
    operator = Operator()
    operator.drop(0.3)
    first, again, other = (
        [frame.stamp for frame in OperatedFrames(FRAMES, operator, seed)] for seed in (0, 0, 1)
    )
    assert 110 < len(first) < 170
    assert first == again != other
    assert first == sorted(first)


def test_a_paused_recording_waits_and_goes_on_by_single_frames():
    operator, taken = Operator(), threading.Semaphore(0)
    operator.pause()
    frames = iter(OperatedFrames(FRAMES[:5], operator))
    stamps: list[float] = []

    def take():
        for frame in frames:
            stamps.append(frame.stamp)
            taken.release()

    thread = threading.Thread(target=take, daemon=True)
    thread.start()
    assert not taken.acquire(timeout=0.1)
    operator.step()
    assert taken.acquire(timeout=10)
    assert not taken.acquire(timeout=0.1)
    operator.resume()
    thread.join(10)
    assert stamps == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_an_operator_may_end_a_recording():
    operator = Operator()
    operator.stop()
    with pytest.raises(RunStopped):
        next(iter(OperatedFrames(FRAMES, operator)))
