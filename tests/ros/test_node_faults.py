"""The node when what it hears is broken, missing, or of another time."""

from __future__ import annotations

import re
import threading
import time
from typing import Any

import pytest
from node_world import SETTINGS, status, values, worked_off
from orbiting_robot import DEPTH, INFO, INTERVAL, OPTICAL, MemoryBus, OrbitingRobot

from circumspect.classification import Classifier
from circumspect.recognition import FrameOutcome
from circumspect.recording.image_messages import camera_info, depth_message
from circumspect.recording.pose_messages import odometry_message, transforms_message
from circumspect.recording.ros_types import IMAGE
from circumspect.ros.middleware import COMMANDS
from circumspect.ros.recognition_node import RecognitionNode
from circumspect.sensing import Odometry


class Faulty(Classifier):
    """Breaks on the second grid."""

    def __init__(self, sound: Classifier) -> None:
        self._sound, self._count = sound, 0

    classes = property(lambda self: self._sound.classes)
    recipe = property(lambda self: self._sound.recipe)

    def classify(self, cloud: Any) -> Any:
        return self._sound.classify(cloud)

    def classify_grid(self, *views: Any, **how: Any) -> Any:
        self._count += 1
        if self._count == 2:
            raise ZeroDivisionError("on purpose")
        return self._sound.classify_grid(*views, **how)


def test_a_fault_inside_costs_a_frame_not_the_node(bus: MemoryBus, classifier: Classifier) -> None:
    node = RecognitionNode(bus, SETTINGS, Faulty(classifier))
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    steps = [node.work(0.02) for _ in range(3)]
    node.close()
    assert [step is None for step in steps] == [False, True, False]
    assert values(node)["left out: a fault inside; see the log"] == 1


BROKEN: dict[str, Any] = {
    "encoding": lambda told: setattr(told, "encoding", "rgb8"),
    "step": lambda told: setattr(told, "step", 3),
    "short": lambda told: setattr(told, "data", told.data[:1000]),
    "height": lambda told: setattr(told, "height", 2**31),
    "large": lambda told: (setattr(told, "height", 5000), setattr(told, "width", 5000)),
    "size": lambda told: setattr(told, "height", 200),
    "nothing": lambda told: (setattr(told, "height", 0), setattr(told, "data", told.data[:0])),
}


@pytest.mark.parametrize("how", BROKEN)
def test_broken_images_are_left_out_and_told(
    bus: MemoryBus, node: RecognitionNode, how: str
) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    frame, place = robot.frames[1]
    robot.tell_place(100.2, place)
    told = depth_message(frame.depth, 100.2, OPTICAL)
    BROKEN[how](told)
    robot.tell_depth(told)
    robot.drive(2)
    assert [step.stamp for step in worked_off(node)] == pytest.approx([100.0, 100.4])
    assert sum(number for what, number in values(node).items() if what.startswith("left out")) == 1


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\7\1\0\0abcd", b"\0\1\0\0" + b"\xff" * 80])
def test_bytes_that_are_no_message(bus: MemoryBus, node: RecognitionNode, data: bytes) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for topic in (DEPTH, INFO, "/odom", "/tf", "/tf_static"):
        bus.advertise(topic, IMAGE, COMMANDS)(data)
    robot.drive(0)
    assert len(worked_off(node)) == 1


def test_a_message_larger_than_any_such(bus: MemoryBus, node: RecognitionNode) -> None:
    OrbitingRobot(bus)
    bus.advertise("/odom", IMAGE, COMMANDS)(b"\0\1\0\0" + bytes(2**21))
    assert any("bytes is left out" in what for what in values(node))


def test_poses_that_are_no_numbers(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    bad = transforms_message(robot.mount.transforms)
    worse = odometry_message(Odometry(100.1, robot.frames[0][1]), "odom", "base_link")
    worse.pose.pose.position.x = float("nan")
    robot.drive(0)
    robot.tell_odometry(worse)
    bad.transforms[0].transform.rotation.w = float("inf")
    robot.tell_static(bad)
    robot.drive(1)
    assert [step.outcome for step in worked_off(node)] == [FrameOutcome.CLASSIFIED] * 2
    assert sum(1 for what in values(node) if what.startswith("left out: a pose")) == 2


def test_odometry_of_another_epoch_is_reported(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(6):
        frame, place = robot.frames[number]
        stamp = 100.0 + INTERVAL * number
        robot.tell_place(stamp + 1.7e9, place)
        robot.tell_info(camera_info(frame.camera, stamp, OPTICAL))
        robot.tell_depth(depth_message(frame.depth, stamp, OPTICAL))
    steps = worked_off(node)
    assert len(steps) == 6
    assert all(step.pose.T_map_odom is None for step in steps)
    assert "different clocks" in status(bus, "different clocks").message


def test_a_clock_that_starts_at_zero_is_a_clock(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(3):
        robot.drive(number, late=-100.0)
    steps = worked_off(node)
    assert [step.stamp for step in steps] == pytest.approx([0.0, 0.2, 0.4])
    assert [step.outcome for step in steps] == [FrameOutcome.CLASSIFIED] * 3
    assert [step.pose.source for step in steps[1:]] == ["odometry"] * 2


def test_without_a_mount_there_is_no_answer_but_a_remedy(
    bus: MemoryBus, node: RecognitionNode
) -> None:
    robot = OrbitingRobot(bus)
    robot.drive(0)
    assert worked_off(node) == []
    assert bus.told("/circumspect/detections") == []
    said = status(bus, "--mount X Y Z PAN TILT")
    assert said.level == 2
    robot.stand()
    robot.drive(1)
    assert len(worked_off(node)) == 1


def test_without_camera_info_there_is_no_answer_but_a_remedy(
    bus: MemoryBus, node: RecognitionNode
) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(20):
        frame, place = robot.frames[number]
        robot.tell_place(100 + 0.2 * number, place)
        for part in range(3):
            robot.tell_depth(depth_message(frame.depth, 100 + 0.2 * number + 0.05 * part, OPTICAL))
    assert worked_off(node) == []
    assert status(bus, f"no CameraInfo on {INFO}").level == 2


def test_nobody_publishes(bus: MemoryBus, node: RecognitionNode) -> None:
    said = status(bus, f"nobody publishes depth images on {DEPTH}")
    assert said.level == 2
    assert said.hardware_id == DEPTH


def test_odometry_that_ends_is_told(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    frame, _ = robot.frames[1]
    robot.tell_depth(depth_message(frame.depth, 105.0, OPTICAL))
    robot.tell_depth(depth_message(frame.depth, 105.2, OPTICAL))  # the first one leapt
    time.sleep(0.55)
    # The next message tells that enough time went by.
    robot.tell_info(camera_info(frame.camera, 105.2, OPTICAL))
    sources = [step.pose.source for step in worked_off(node)]
    assert sources == ["initial pose", "constant velocity", "constant velocity"]
    assert "by registration alone" in node.health.status(True, None, 0).text


def test_a_clock_that_is_set_back_begins_anew(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    worked_off(node)
    for number in range(3, 5):
        robot.drive(number, late=-50.0)  # the images by which it is noticed
    for number in range(5, 8):
        robot.drive(number, late=-50.0)
    steps = worked_off(node)
    assert [step.outcome for step in steps] == [FrameOutcome.CLASSIFIED] * 3
    assert steps[-1].model.frames == 3
    assert any(re.search(r"the clock leapt by -(49|50)\.", what) for what in values(node))


def test_a_clock_that_leaps_on_keeps_the_model(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    worked_off(node)
    for number in range(3, 7):
        robot.drive(number, late=1e6)
    assert worked_off(node)[-1].model.frames == 5


def test_one_odometry_from_the_far_future_does_not_end_odometry(
    bus: MemoryBus, node: RecognitionNode
) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    robot.tell_place(1e6, robot.frames[0][1])
    for number in range(1, 4):
        robot.drive(number)
    assert [step.pose.source for step in worked_off(node)][1:] == ["odometry"] * 3


def test_the_diagnostics_go_on_while_a_frame_takes_long(
    bus: MemoryBus, classifier: Classifier
) -> None:
    class Slow(Faulty):
        def classify_grid(self, *views: Any, **how: Any) -> Any:
            time.sleep(2.5)
            return self._sound.classify_grid(*views, **how)

    node = RecognitionNode(bus, SETTINGS, Slow(classifier))
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    before = len(bus.told("/diagnostics"))
    worker = threading.Thread(target=node.work)
    worker.start()
    worker.join()
    assert len(bus.told("/diagnostics")) >= before + 2
    node.close()


class Watching:
    """Notes the commands that the node tells of."""

    def __init__(self) -> None:
        self.commands: list[str] = []

    def on_command(self, command: str) -> None:
        self.commands.append(command)

    def on_step(self, step: Any) -> None: ...

    def on_settled(self, prediction: Any) -> None: ...

    def on_status(self, status: Any) -> None: ...


def test_who_watches_hears_that_the_node_began_anew_by_itself(
    bus: MemoryBus, node: RecognitionNode
) -> None:
    watching = Watching()
    node.observers = (watching,)
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    for number in range(1, 3):
        robot.drive(number, late=-50.0)
    worked_off(node)
    assert watching.commands == ["reset"]


@pytest.mark.parametrize("command", ["stop", "reset"])
def test_a_frame_that_waits_for_odometry_is_dropped_with_the_others(
    bus: MemoryBus, node: RecognitionNode, command: str
) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    frame, place = robot.frames[1]
    robot.tell_depth(depth_message(frame.depth, 100.2, OPTICAL))
    assert len(worked_off(node)) == 1, "the second one waits"
    node.command(command)
    node.work(0)
    node.command("start")
    node.work(0)
    robot.tell_place(100.2, place)
    robot.drive(2)
    assert [step.stamp for step in worked_off(node)] == pytest.approx([100.4])
