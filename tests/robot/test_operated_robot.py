"""An operator pauses, steps, slows down, disturbs and stops a robot, without deadlock."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.robot import MobileRobot, OperatedRobot, Operator, RunStopped, Velocity
from circumspect.sensing import Odometry, RgbdCamera, RgbdFrame

CAMERA = PinholeCamera(4, 3, 4.0, 4.0, 1.5, 1.0)
LONG = 20.0


class _Camera(RgbdCamera):
    taken = 0

    @property
    def intrinsics(self) -> PinholeCamera:
        return CAMERA

    def capture(self) -> RgbdFrame:
        self.taken += 1
        colour = np.full((3, 4, 3), 200, np.uint8)
        return RgbdFrame(np.ones((3, 4)), CAMERA, float(self.taken), colour=colour)


class _Robot(MobileRobot):
    """Stays in place; time passes only in `wait`, which records the commanded velocity."""

    def __init__(self) -> None:
        self._camera = _Camera()
        self._now = 0.0
        self.commanded = Velocity()
        self.waited_at: list[Velocity] = []

    camera = property(lambda self: self._camera)
    T_base_camera = property(lambda self: RigidTransform.identity())
    radius = property(lambda self: 0.3)
    now = property(lambda self: self._now)
    max_forward = property(lambda self: 1.0)
    max_turn = property(lambda self: 1.0)

    def odometry(self) -> Odometry | None:
        return None

    def drive(self, velocity: Velocity) -> None:
        self.commanded = velocity

    def wait(self, seconds: float) -> None:
        self._now += seconds
        self.waited_at.append(self.commanded)


class _Observing(threading.Thread):
    """Takes frames until it is stopped, as a run does."""

    def __init__(self, operator: Operator) -> None:
        super().__init__(daemon=True)
        self.robot = _Robot()
        self.frames: list[RgbdFrame] = []
        self.stopped = False
        self._operated = OperatedRobot(self.robot, operator)

    def run(self) -> None:
        try:
            while True:
                self.frames.append(self._operated.observe())
                time.sleep(0.001)
        except RunStopped:
            self.stopped = True


def until(condition, seconds: float = LONG) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.005)


@pytest.fixture
def operator():
    operator = Operator()
    yield operator
    operator.stop()


def test_a_paused_run_takes_no_frame_and_one_step_takes_exactly_one(operator):
    operator.pause()
    run = _Observing(operator)
    run.start()
    time.sleep(0.05)
    assert run.frames == []
    for count in (1, 2):
        operator.step()
        until(lambda count=count: len(run.frames) == count)
        time.sleep(0.05)
        assert len(run.frames) == count
        assert operator.paused
    operator.resume()
    until(lambda: len(run.frames) > 4)


def test_stop_ends_a_run_that_is_paused(operator):
    operator.pause()
    run = _Observing(operator)
    run.start()
    operator.stop()
    run.join(LONG)
    assert run.stopped
    assert run.frames == []


def test_a_frame_rate_is_kept_and_can_be_reset(operator):
    operator.set_pace(10.0)
    run = _Observing(operator)
    began = time.monotonic()
    run.start()
    until(lambda: len(run.frames) >= 4)
    assert time.monotonic() - began >= 0.29
    operator.set_pace(0.1)
    count = len(run.frames)
    operator.set_pace(None)
    until(lambda: len(run.frames) > count + 5)


def test_covering_the_camera_hides_depth_until_uncovered(operator):
    robot = OperatedRobot(_Robot(), operator)
    operator.cover(True)
    frame = robot.observe()
    assert not frame.valid.any()
    assert frame.colour.max() == 0
    operator.cover(False)
    assert robot.observe().valid.all()


def test_time_passes_for_dropped_frames(operator):
    inner = _Robot()
    robot = OperatedRobot(inner, operator, seed=3)
    for _ in range(50):
        robot.observe()
    assert inner.now == 0.0
    operator.drop(0.5)
    for _ in range(200):
        robot.observe()
    assert inner.now / 0.5 == pytest.approx(200, rel=0.4)


def test_a_paused_robot_stands(operator):
    operator.pause()
    run = _Observing(operator)
    run.robot.drive(Velocity(0.3))
    run.start()
    until(lambda: run.robot.commanded == Velocity())
    assert run.frames == []


def test_a_robot_that_is_not_paused_drives_on(operator):
    inner = _Robot()
    robot = OperatedRobot(inner, operator)
    robot.drive(Velocity(0.3))
    for _ in range(5):
        robot.observe()
    assert inner.commanded == Velocity(0.3)


def test_a_robot_stands_after_a_dropped_frame_until_the_next(operator):
    inner = _Robot()
    robot = OperatedRobot(inner, operator, seed=3)
    operator.drop(0.9)
    robot.drive(Velocity(0.3))
    robot.observe()
    assert inner.waited_at
    assert set(inner.waited_at) == {Velocity()}


@pytest.mark.parametrize("fraction", [-0.1, 0.95, 1.0, float("nan")])
def test_an_invalid_drop_rate_is_refused(operator, fraction):
    with pytest.raises(InputError, match="fraction of lost frames"):
        operator.drop(fraction)


@pytest.mark.parametrize("pace", [0.0, -1.0, float("nan"), float("inf")])
def test_an_invalid_frame_rate_is_refused(operator, pace):
    with pytest.raises(InputError, match="frames per second"):
        operator.set_pace(pace)
