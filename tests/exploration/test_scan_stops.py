"""However a scan ends, the robot stands before anything else is done."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace

import pytest
from scan_world import QUICK, scan
from volume_classifier import VolumeClassifier

from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.exploration.object_scan import ObjectScan
from circumspect.exploration.view_record import ViewOutcome
from circumspect.planning import CirclePlanner, ConfidencePlanner, StoppingCriterion
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.robot import MobileRobot, OperatedRobot, Operator, Velocity, WrappedRobot
from circumspect.sensing import RgbdFrame
from circumspect.tracking import KnownPoses

STILL = Velocity()
FEW = replace(QUICK, most_frames=8)


class Wheels(WrappedRobot):
    """Remembers what they were last told."""

    told = STILL

    def drive(self, velocity: Velocity) -> None:
        self.told = velocity
        super().drive(velocity)


class Settling(KnownPoses):
    """Notes what the wheels do while loops are closed."""

    def __init__(self) -> None:
        self.wheels: Wheels | None = None
        self.told: list[Velocity] = []

    def finalise(self) -> None:
        assert self.wheels is not None
        self.told.append(self.wheels.told)


class Slow:
    """An observer that fails at a step, or not, and notes what the wheels do."""

    def __init__(self, wheels: Wheels, fails_at: int | None = None) -> None:
        self._wheels, self._fails_at = wheels, fails_at
        self.at_steps: list[Velocity] = []
        self.at_end: list[Velocity] = []

    def on_step(self, step: RecognitionStep) -> None:
        self.at_steps.append(self._wheels.told)
        if step.index == self._fails_at:
            raise RuntimeError("the disk is full")

    def on_end(self, result: RecognitionResult) -> None:
        self.at_end.append(self._wheels.told)


class Broken(WrappedRobot):
    """Its camera fails after some frames."""

    def __init__(self, robot: MobileRobot, after: int) -> None:
        super().__init__(robot)
        self._left = after

    def observe(self) -> RgbdFrame:
        self._left -= 1
        if self._left < 0:
            raise OSError("the camera is unplugged")
        return super().observe()


def watched(going: ObjectScan, fails_at: int | None = None) -> tuple[ObjectScan, Slow]:
    """The same scan with wheels that are watched."""
    wheels = Wheels(going.robot)
    going.pipeline.tracker.estimator.wheels = wheels
    slow = Slow(wheels, fails_at)
    return ObjectScan(wheels, going.pipeline, going.planner, going.settings), slow


def ended_while_driving(going: ObjectScan, slow: Slow) -> None:
    assert slow.at_steps[-1] != STILL, "it ended standing, which proves nothing"
    assert going.pipeline.tracker.estimator.told == [STILL]
    assert slow.at_end == [STILL]


def test_at_the_limit_of_frames() -> None:
    going, slow = watched(scan(poses=Settling(), settings=FEW))
    going.run((slow,))
    assert going.ended == "the limit of 8 frames is reached"
    ended_while_driving(going, slow)


def test_when_the_answer_is_confident() -> None:
    likely = VolumeClassifier(ConfidenceRule(coverage=(0.35,), probability=(0.5,)))
    planner = ConfidencePlanner(CirclePlanner(), StoppingCriterion(frames=2))
    going, slow = watched(scan(poses=Settling(), planner=planner, classifier=likely))
    going.run((slow,))
    assert going.ended.startswith("the answer is confident: ")
    ended_while_driving(going, slow)


def test_at_a_fault_of_a_step() -> None:
    going, slow = watched(scan(poses=Settling()), fails_at=6)
    with pytest.raises(RuntimeError, match="the disk is full"):
        going.run((slow,))
    ended_while_driving(going, slow)


def test_at_a_fault_of_the_camera() -> None:
    going, slow = watched(scan(poses=Settling(), fault=lambda robot: Broken(robot, 7)))
    with pytest.raises(OSError, match="unplugged"):
        going.run((slow,))
    ended_while_driving(going, slow)


def test_at_ctrl_c(ctrl_c_at: Callable[[int], None]) -> None:
    ctrl_c_at(8)
    going, slow = watched(scan(poses=Settling()))
    with pytest.raises(KeyboardInterrupt):
        going.run((slow,))
    ended_while_driving(going, slow)


class SlowOperator(Operator):
    """Takes a minute over every frame."""

    def __init__(self) -> None:
        super().__init__()
        self.clock = 0.0

    def admit(self, before_waiting: Callable[[], None] | None = None) -> None:
        assert before_waiting is not None
        before_waiting()
        self.clock += 60.0


class Clocked(WrappedRobot):
    """Its time goes on while it is held, as a real robot's does."""

    def __init__(self, robot: MobileRobot, operator: SlowOperator) -> None:
        super().__init__(robot)
        self._operator = operator

    @property
    def now(self) -> float:
        return self.robot.now + self._operator.clock

    def observe(self) -> RgbdFrame:
        frame = super().observe()
        return replace(frame, stamp=frame.stamp + self._operator.clock)


@pytest.mark.parametrize("speed", [0.05, 0.2])
def test_a_robot_that_is_held_over_and_over_is_not_taken_for_blocked(speed: float) -> None:
    going, operator = scan(settings=replace(QUICK, speed=speed, most_frames=40)), SlowOperator()
    robot = OperatedRobot(Clocked(going.robot, operator), operator)
    going = ObjectScan(robot, going.pipeline, going.planner, going.settings)
    going.run()
    assert going.ended == "the limit of 40 frames is reached"
    assert ViewOutcome.BLOCKED not in {record.outcome for record in going.views}
    assert robot.held == pytest.approx(40 * 60.0)


def test_a_paused_scan_stands() -> None:
    operator = Operator()
    going, slow = watched(scan(poses=Settling(), settings=FEW))
    wheels = going.robot
    going = ObjectScan(OperatedRobot(wheels, operator), going.pipeline, going.planner, FEW)

    class Pausing:
        def on_step(self, step: RecognitionStep) -> None:
            if step.index == 6:
                operator.pause()

        def on_end(self, result: RecognitionResult) -> None:
            pass

    run = threading.Thread(target=going.run, args=((slow, Pausing()),), daemon=True)
    run.start()
    try:
        deadline = time.monotonic() + 20.0
        while len(slow.at_steps) < 7 or wheels.told != STILL:
            assert time.monotonic() < deadline, f"paused, and the wheels are told {wheels.told}"
            time.sleep(0.005)
        assert slow.at_steps[-1] != STILL
    finally:
        operator.resume()
        run.join(20.0)
    assert going.ended == "the limit of 8 frames is reached"
