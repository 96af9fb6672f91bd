"""Frames put together of messages as they come: pauses, and a stop in between."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from node_world import SETTINGS, worked_off
from orbiting_robot import MemoryBus, OrbitingRobot

from circumspect.recording.ros_types import IMAGE
from circumspect.ros import live_frames
from circumspect.ros.health import Health
from circumspect.ros.live_frames import LiveFrames
from circumspect.ros.recognition_node import RecognitionNode
from circumspect.ros.wire_messages import unpacked


class Clock:
    """Stands still unless it is moved."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_source_that_pauses_is_no_clock_that_was_set_back(bus: MemoryBus) -> None:
    clock = Clock()
    frames = LiveFrames(bus, SETTINGS, Health(), clock)
    frames.taking = True
    robot = OrbitingRobot(bus)
    robot.stand()
    seen = []
    for number in range(4):
        robot.drive(number)
        while (frame := frames.take(0.0)) is not None:
            seen.append(frame.stamp)
        clock.now += 600.0 if number == 1 else 0.2
    assert seen == pytest.approx([100.0, 100.2, 100.4, 100.6])
    assert frames.leaps_back == 0
    robot.drive(4, late=-50.0)
    assert frames.leaps_back == 0  # one image may be wrong
    robot.drive(5, late=-50.0)
    assert frames.leaps_back == 1


def test_poses_of_a_localization_that_died_are_not_taken(bus: MemoryBus) -> None:
    clock, health = Clock(), Health()
    given = replace(SETTINGS, poses="given", map_frame="odom", odometry="")
    frames = LiveFrames(bus, given, health, clock)
    frames.taking = True
    robot = OrbitingRobot(bus, odometry=False)
    robot.stand()
    for number in range(10):
        if number == 3:
            robot.tell_tf = lambda told: None
        robot.drive(number)
        clock.now += 0.2
    seen = []
    while (frame := frames.take(0.0)) is not None:
        seen.append(frame.stamp)
    assert seen == pytest.approx([100.0, 100.2, 100.4, 100.6, 100.8])
    missing = frames.missing()
    assert missing is not None
    assert "no transforms link odom to the camera's frame at the images' time" in missing
    assert health.status(True, None, 0).values["left out: no transforms tell where the camera is"]


def test_an_image_on_its_way_when_the_node_is_stopped_makes_no_frame(
    bus: MemoryBus, node: RecognitionNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    assert len(worked_off(node)) == 1

    def stopping(kind: str, data: bytes) -> Any:
        told = unpacked(kind, data)
        if kind == IMAGE:
            node.command("stop")
            node.work(0)
        return told

    with monkeypatch.context() as patched:
        patched.setattr(live_frames, "unpacked", stopping)
        robot.drive(1)
    assert not node.running
    assert worked_off(node) == []
    node.command("start")
    node.work(0)
    robot.drive(2)
    assert [step.stamp for step in worked_off(node)] == pytest.approx([100.4])
    assert node.health.status(True, None, 0).values["depth heard"] == 3


def test_images_without_stamps_are_stamped_when_they_arrive(bus: MemoryBus) -> None:
    clock, health = Clock(), Health()
    frames = LiveFrames(bus, replace(SETTINGS, odometry=""), health, clock, lambda: 50 + clock.now)
    frames.taking = True
    robot = OrbitingRobot(bus, odometry=False)
    robot.stand()
    seen = []
    for number in range(5):
        robot.drive(number, late=-(100.0 + 0.2 * number))
        clock.now += 1.0
        while (frame := frames.take(0.0)) is not None:
            seen.append(frame.stamp)
    assert seen[0] == 0.0, "simulated time begins at zero, too"
    assert seen[1:] == pytest.approx([51.0, 52.0, 53.0]), "the last one waits for transforms"
    assert frames.leaps_back == 1
    values = health.status(True, None, 0).values
    assert any("are zero; the time of arrival is used" in name for name in values)


@pytest.mark.parametrize(
    ("driver", "given", "expected"),
    [
        ("realsense", (), (0.3, 3.0)),
        ("orbbec", (), (0.6, 5.0)),
        ("openni", (), (0.8, 3.5)),
        ("realsense", (0.2, 6.0), (0.2, 6.0)),
    ],
)
def test_a_driver_sets_the_depth_range_of_its_camera(
    driver: Any, given: tuple[float, ...], expected: tuple[float, float]
) -> None:
    settings = replace(SETTINGS, driver=driver, depth_range=given)
    assert settings.noise.depth_range == expected
