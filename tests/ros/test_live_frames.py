"""Frames assembled from live messages, with pauses and a stop in between."""

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
from circumspect.ros.wire_messages import deserialized


class Clock:
    """Stands still unless it is moved."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_paused_source_is_no_clock_jump(bus: MemoryBus) -> None:
    clock = Clock()
    frames = LiveFrames(bus, SETTINGS, Health(), clock)
    frames.taking = True
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    stamps = []
    for number in range(4):
        robot.publish_frame(number)
        while (frame := frames.take(0.0)) is not None:
            stamps.append(frame.stamp)
        clock.now += 600.0 if number == 1 else 0.2
    assert stamps == pytest.approx([100.0, 100.2, 100.4, 100.6])
    assert frames.backward_jumps == 0
    robot.publish_frame(4, late=-50.0)
    assert frames.backward_jumps == 0  # one image may be wrong
    robot.publish_frame(5, late=-50.0)
    assert frames.backward_jumps == 1


def test_frames_after_the_localization_stopped_are_skipped(bus: MemoryBus) -> None:
    clock, health = Clock(), Health()
    given = replace(SETTINGS, poses="given", map_frame="odom", odometry="")
    frames = LiveFrames(bus, given, health, clock)
    frames.taking = True
    robot = OrbitingRobot(bus, odometry=False)
    robot.publish_mount()
    for number in range(10):
        if number == 3:
            robot.publish_tf = lambda msg: None
        robot.publish_frame(number)
        clock.now += 0.2
    stamps = []
    while (frame := frames.take(0.0)) is not None:
        stamps.append(frame.stamp)
    assert stamps == pytest.approx([100.0, 100.2, 100.4, 100.6, 100.8])
    missing = frames.missing()
    assert missing is not None
    assert "no transforms link odom to the camera's frame at the time of the images" in missing
    assert health.status(True, None, 0).values[
        "skipped: no transforms give the camera's mount or pose"
    ]


def test_an_image_that_arrives_while_the_node_is_stopped_makes_no_frame(
    bus: MemoryBus, node: RecognitionNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    assert len(worked_off(node)) == 1

    def stopping(kind: str, data: bytes) -> Any:
        msg = deserialized(kind, data)
        if kind == IMAGE:
            node.command("stop")
            node.work(0)
        return msg

    with monkeypatch.context() as patched:
        patched.setattr(live_frames, "deserialized", stopping)
        robot.publish_frame(1)
    assert not node.running
    assert worked_off(node) == []
    node.command("start")
    node.work(0)
    robot.publish_frame(2)
    assert [step.stamp for step in worked_off(node)] == pytest.approx([100.4])
    assert node.health.status(True, None, 0).values["depth received"] == 3


def test_images_without_stamps_are_stamped_when_they_arrive(bus: MemoryBus) -> None:
    clock, health = Clock(), Health()
    frames = LiveFrames(bus, replace(SETTINGS, odometry=""), health, clock, lambda: 50 + clock.now)
    frames.taking = True
    robot = OrbitingRobot(bus, odometry=False)
    robot.publish_mount()
    stamps = []
    for number in range(5):
        robot.publish_frame(number, late=-(100.0 + 0.2 * number))
        clock.now += 1.0
        while (frame := frames.take(0.0)) is not None:
            stamps.append(frame.stamp)
    assert stamps[0] == 0.0, "simulated time begins at zero, too"
    assert stamps[1:] == pytest.approx([51.0, 52.0, 53.0]), "the last one waits for transforms"
    assert frames.backward_jumps == 1
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
