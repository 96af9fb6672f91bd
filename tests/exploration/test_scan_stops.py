"""The robot stops before anything else is done, however a scan ends."""

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
FEW = replace(QUICK, max_frames=8)


class Wheels(WrappedRobot):
    """Keeps the last commanded velocity."""

    commanded = STILL

    def drive(self, velocity: Velocity) -> None:
        self.commanded = velocity
        super().drive(velocity)


class Settling(KnownPoses):
    """Keeps the commanded velocity during loop closure."""

    def __init__(self) -> None:
        self.wheels: Wheels | None = None
        self.velocities: list[Velocity] = []

    def finalise(self) -> None:
        assert self.wheels is not None
        self.velocities.append(self.wheels.commanded)


class Slow:
    """An observer that may fail at a step, and keeps the commanded velocities."""

    def __init__(self, wheels: Wheels, fails_at: int | None = None) -> None:
        self._wheels, self._fails_at = wheels, fails_at
        self.at_steps: list[Velocity] = []
        self.at_end: list[Velocity] = []

    def on_step(self, step: RecognitionStep) -> None:
        self.at_steps.append(self._wheels.commanded)
        if step.index == self._fails_at:
            raise RuntimeError("the disk is full")

    def on_end(self, result: RecognitionResult) -> None:
        self.at_end.append(self._wheels.commanded)


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


def watched(object_scan: ObjectScan, fails_at: int | None = None) -> tuple[ObjectScan, Slow]:
    """The same scan, with its commanded velocities recorded."""
    wheels = Wheels(object_scan.robot)
    object_scan.pipeline.tracker.estimator.wheels = wheels
    slow = Slow(wheels, fails_at)
    return ObjectScan(wheels, object_scan.pipeline, object_scan.planner, object_scan.settings), slow


def ended_while_driving(object_scan: ObjectScan, slow: Slow) -> None:
    assert slow.at_steps[-1] != STILL, "the robot stood already"
    assert object_scan.pipeline.tracker.estimator.velocities == [STILL]
    assert slow.at_end == [STILL]


def test_the_robot_stops_at_the_limit_of_frames() -> None:
    object_scan, slow = watched(scan(poses=Settling(), settings=FEW))
    object_scan.run((slow,))
    assert object_scan.ended == "the limit of 8 frames is reached"
    ended_while_driving(object_scan, slow)


def test_the_robot_stops_when_the_answer_is_confident() -> None:
    likely = VolumeClassifier(ConfidenceRule(coverage=(0.35,), probability=(0.5,)))
    planner = ConfidencePlanner(CirclePlanner(), StoppingCriterion(frames=2))
    object_scan, slow = watched(scan(poses=Settling(), planner=planner, classifier=likely))
    object_scan.run((slow,))
    assert object_scan.ended.startswith("the answer is confident: ")
    ended_while_driving(object_scan, slow)


def test_the_robot_stops_at_an_error_of_an_observer() -> None:
    object_scan, slow = watched(scan(poses=Settling()), fails_at=6)
    with pytest.raises(RuntimeError, match="the disk is full"):
        object_scan.run((slow,))
    ended_while_driving(object_scan, slow)


def test_the_robot_stops_at_an_error_of_the_camera() -> None:
    object_scan, slow = watched(scan(poses=Settling(), fault=lambda robot: Broken(robot, 7)))
    with pytest.raises(OSError, match="unplugged"):
        object_scan.run((slow,))
    ended_while_driving(object_scan, slow)


def test_the_robot_stops_at_ctrl_c(ctrl_c_at: Callable[[int], None]) -> None:
    ctrl_c_at(8)
    object_scan, slow = watched(scan(poses=Settling()))
    with pytest.raises(KeyboardInterrupt):
        object_scan.run((slow,))
    ended_while_driving(object_scan, slow)


class SlowOperator(Operator):
    """Takes a minute over every frame."""

    def __init__(self) -> None:
        super().__init__()
        self.clock = 0.0

    def wait_for_frame(self, on_wait: Callable[[], None] | None = None) -> None:
        assert on_wait is not None
        on_wait()
        self.clock += 60.0


class Clocked(WrappedRobot):
    """Its time passes while it is paused, as on a real robot."""

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
def test_a_robot_paused_at_every_frame_is_not_taken_for_blocked(speed: float) -> None:
    object_scan, operator = (
        scan(settings=replace(QUICK, speed=speed, max_frames=40)),
        SlowOperator(),
    )
    robot = OperatedRobot(Clocked(object_scan.robot, operator), operator)
    object_scan = ObjectScan(robot, object_scan.pipeline, object_scan.planner, object_scan.settings)
    object_scan.run()
    assert object_scan.ended == "the limit of 40 frames is reached"
    assert ViewOutcome.BLOCKED not in {record.outcome for record in object_scan.views}
    assert robot.paused_seconds == pytest.approx(40 * 60.0)


def test_the_robot_stops_when_the_scan_is_paused() -> None:
    operator = Operator()
    object_scan, slow = watched(scan(poses=Settling(), settings=FEW))
    wheels = object_scan.robot
    object_scan = ObjectScan(
        OperatedRobot(wheels, operator), object_scan.pipeline, object_scan.planner, FEW
    )

    class Pausing:
        def on_step(self, step: RecognitionStep) -> None:
            if step.index == 6:
                operator.pause()

        def on_end(self, result: RecognitionResult) -> None:
            pass

    run = threading.Thread(target=object_scan.run, args=((slow, Pausing()),), daemon=True)
    run.start()
    try:
        deadline = time.monotonic() + 20.0
        while len(slow.at_steps) < 7 or wheels.commanded != STILL:
            assert time.monotonic() < deadline, (
                f"paused at a commanded velocity of {wheels.commanded}"
            )
            time.sleep(0.005)
        assert slow.at_steps[-1] != STILL
    finally:
        operator.resume()
        run.join(20.0)
    assert object_scan.ended == "the limit of 8 frames is reached"
