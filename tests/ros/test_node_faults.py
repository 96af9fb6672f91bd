"""The node with messages that are broken, missing, or of another clock."""

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
    input_spec = property(lambda self: self._sound.input_spec)

    def classify(self, cloud: Any) -> Any:
        return self._sound.classify(cloud)

    def classify_grid(self, *views: Any, **keywords: Any) -> Any:
        self._count += 1
        if self._count == 2:
            raise ZeroDivisionError("on purpose")
        return self._sound.classify_grid(*views, **keywords)


def test_an_internal_error_skips_one_frame(bus: MemoryBus, classifier: Classifier) -> None:
    node = RecognitionNode(bus, SETTINGS, Faulty(classifier))
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(3):
        robot.publish_frame(number)
    steps = [node.work(0.02) for _ in range(3)]
    node.close()
    assert [step is None for step in steps] == [False, True, False]
    assert values(node)["skipped: internal error; see the log"] == 1


BROKEN: dict[str, Any] = {
    "encoding": lambda msg: setattr(msg, "encoding", "rgb8"),
    "step": lambda msg: setattr(msg, "step", 3),
    "short": lambda msg: setattr(msg, "data", msg.data[:1000]),
    "height": lambda msg: setattr(msg, "height", 2**31),
    "large": lambda msg: (setattr(msg, "height", 5000), setattr(msg, "width", 5000)),
    "size": lambda msg: setattr(msg, "height", 200),
    "nothing": lambda msg: (setattr(msg, "height", 0), setattr(msg, "data", msg.data[:0])),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_broken_images_are_skipped_and_counted(
    bus: MemoryBus, node: RecognitionNode, fault: str
) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    frame, place = robot.frames[1]
    robot.publish_place(100.2, place)
    msg = depth_message(frame.depth, 100.2, OPTICAL)
    BROKEN[fault](msg)
    robot.publish_depth(msg)
    robot.publish_frame(2)
    assert [step.stamp for step in worked_off(node)] == pytest.approx([100.0, 100.4])
    assert sum(number for what, number in values(node).items() if what.startswith("skipped: ")) == 1


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\7\1\0\0abcd", b"\0\1\0\0" + b"\xff" * 80])
def test_bytes_that_are_no_message_are_ignored(
    bus: MemoryBus, node: RecognitionNode, data: bytes
) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for topic in (DEPTH, INFO, "/odom", "/tf", "/tf_static"):
        bus.advertise(topic, IMAGE, COMMANDS)(data)
    robot.publish_frame(0)
    assert len(worked_off(node)) == 1


def test_a_too_large_message_is_reported(bus: MemoryBus, node: RecognitionNode) -> None:
    OrbitingRobot(bus)
    bus.advertise("/odom", IMAGE, COMMANDS)(b"\0\1\0\0" + bytes(2**21))
    assert any("bytes is too large" in what for what in values(node))


def test_poses_that_are_not_finite_are_skipped_and_counted(
    bus: MemoryBus, node: RecognitionNode
) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    bad = transforms_message(robot.mount.transforms)
    worse = odometry_message(Odometry(100.1, robot.frames[0][1]), "odom", "base_link")
    worse.pose.pose.position.x = float("nan")
    robot.publish_frame(0)
    robot.publish_odometry(worse)
    bad.transforms[0].transform.rotation.w = float("inf")
    robot.publish_static(bad)
    robot.publish_frame(1)
    assert [step.outcome for step in worked_off(node)] == [FrameOutcome.CLASSIFIED] * 2
    assert sum(1 for what in values(node) if what.startswith("skipped: an invalid pose")) == 2


def test_odometry_of_another_epoch_is_reported(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(6):
        frame, place = robot.frames[number]
        stamp = 100.0 + INTERVAL * number
        robot.publish_place(stamp + 1.7e9, place)
        robot.publish_info(camera_info(frame.camera, stamp, OPTICAL))
        robot.publish_depth(depth_message(frame.depth, stamp, OPTICAL))
    steps = worked_off(node)
    assert len(steps) == 6
    assert all(step.pose.T_map_odom is None for step in steps)
    assert "different clocks" in status(bus, "different clocks").message


def test_a_clock_that_starts_at_zero_is_accepted(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(3):
        robot.publish_frame(number, late=-100.0)
    steps = worked_off(node)
    assert [step.stamp for step in steps] == pytest.approx([0.0, 0.2, 0.4])
    assert [step.outcome for step in steps] == [FrameOutcome.CLASSIFIED] * 3
    assert [step.pose.source for step in steps[1:]] == ["odometry"] * 2


def test_a_missing_mount_is_reported_with_a_remedy(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_frame(0)
    assert worked_off(node) == []
    assert bus.received("/circumspect/detections") == []
    said = status(bus, "--mount X Y Z PAN TILT")
    assert said.level == 2
    robot.publish_mount()
    robot.publish_frame(1)
    assert len(worked_off(node)) == 1


def test_missing_camera_info_is_reported(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(20):
        frame, place = robot.frames[number]
        robot.publish_place(100 + 0.2 * number, place)
        for part in range(3):
            robot.publish_depth(
                depth_message(frame.depth, 100 + 0.2 * number + 0.05 * part, OPTICAL)
            )
    assert worked_off(node) == []
    assert status(bus, f"no CameraInfo on {INFO}").level == 2


def test_a_topic_without_publishers_is_reported(bus: MemoryBus, node: RecognitionNode) -> None:
    said = status(bus, f"nobody publishes depth images on {DEPTH}")
    assert said.level == 2
    assert said.hardware_id == DEPTH


def test_missing_odometry_is_reported(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    frame, _ = robot.frames[1]
    robot.publish_depth(depth_message(frame.depth, 105.0, OPTICAL))
    robot.publish_depth(depth_message(frame.depth, 105.2, OPTICAL))  # a clock jump needs two
    time.sleep(0.55)
    # The next message shows that enough time has passed.
    robot.publish_info(camera_info(frame.camera, 105.2, OPTICAL))
    sources = [step.pose.source for step in worked_off(node)]
    assert sources == ["initial pose", "constant velocity", "constant velocity"]
    assert "from registration only" in node.health.status(True, None, 0).text


def test_a_backward_clock_jump_resets_the_model(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(3):
        robot.publish_frame(number)
    worked_off(node)
    for number in range(3, 5):
        robot.publish_frame(number, late=-50.0)  # two images that reveal the jump
    for number in range(5, 8):
        robot.publish_frame(number, late=-50.0)
    steps = worked_off(node)
    assert [step.outcome for step in steps] == [FrameOutcome.CLASSIFIED] * 3
    assert steps[-1].model.frames == 3
    assert any(re.search(r"the clock jumped by -(49|50)\.", what) for what in values(node))


def test_a_forward_clock_jump_keeps_the_model(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(3):
        robot.publish_frame(number)
    worked_off(node)
    for number in range(3, 7):
        robot.publish_frame(number, late=1e6)
    assert worked_off(node)[-1].model.frames == 5


def test_one_odometry_message_of_the_far_future_is_ignored(
    bus: MemoryBus, node: RecognitionNode
) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    robot.publish_place(1e6, robot.frames[0][1])
    for number in range(1, 4):
        robot.publish_frame(number)
    assert [step.pose.source for step in worked_off(node)][1:] == ["odometry"] * 3


def test_diagnostics_are_published_during_a_slow_frame(
    bus: MemoryBus, classifier: Classifier
) -> None:
    class Slow(Faulty):
        def classify_grid(self, *views: Any, **keywords: Any) -> Any:
            time.sleep(2.5)
            return self._sound.classify_grid(*views, **keywords)

    node = RecognitionNode(bus, SETTINGS, Slow(classifier))
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    before = len(bus.received("/diagnostics"))
    worker = threading.Thread(target=node.work)
    worker.start()
    worker.join()
    assert len(bus.received("/diagnostics")) >= before + 2
    node.close()


class Watching:
    """Keeps the commands that the node reports."""

    def __init__(self) -> None:
        self.commands: list[str] = []

    def on_command(self, command: str) -> None:
        self.commands.append(command)

    def on_step(self, step: Any) -> None: ...

    def on_finalised(self, prediction: Any) -> None: ...

    def on_status(self, status: Any) -> None: ...


def test_observers_are_notified_of_an_automatic_reset(
    bus: MemoryBus, node: RecognitionNode
) -> None:
    watching = Watching()
    node.observers = (watching,)
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    for number in range(1, 3):
        robot.publish_frame(number, late=-50.0)
    worked_off(node)
    assert watching.commands == ["reset"]


@pytest.mark.parametrize("command", ["stop", "reset"])
def test_stop_and_reset_drop_a_frame_that_waits_for_odometry(
    bus: MemoryBus, node: RecognitionNode, command: str
) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    frame, place = robot.frames[1]
    robot.publish_depth(depth_message(frame.depth, 100.2, OPTICAL))
    assert len(worked_off(node)) == 1, "the second one waits"
    node.command(command)
    node.work(0)
    node.command("start")
    node.work(0)
    robot.publish_place(100.2, place)
    robot.publish_frame(2)
    assert [step.stamp for step in worked_off(node)] == pytest.approx([100.4])
