"""The node over a bus in memory: all of its logic, none of the network."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from orbiting_robot import DEPTH, INFO, OPTICAL, MemoryBus, OrbitingRobot, orbit

from circumspect.classification import Classifier
from circumspect.pipeline import CLASSIFIED
from circumspect.recording.image_messages import camera_info, depth_message
from circumspect.recording.pose_messages import odometry_message, transforms_message
from circumspect.recording.ros_types import DETECTIONS, IMAGE, message
from circumspect.ros.middleware import ANSWERS, COMMANDS, LATEST
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.outgoing import EMPTY, PATH, POINTS, POSE
from circumspect.ros.recognition_node import RecognitionNode
from circumspect.ros.wire_messages import packed
from circumspect.sensing import Odometry

SETTINGS = NodeSettings(depth=DEPTH, rate=0.0, queue=50)


@pytest.fixture(scope="module")
def classifier() -> Classifier:
    return Classifier.load(threads=1)


@pytest.fixture
def bus() -> MemoryBus:
    return MemoryBus()


@pytest.fixture
def made(bus: MemoryBus, classifier: Classifier) -> Iterator[Any]:
    """Makes nodes with other settings than usual."""
    nodes: list[RecognitionNode] = []

    def make(**changed: Any) -> RecognitionNode:
        nodes.append(RecognitionNode(bus, replace(SETTINGS, **changed), classifier))
        return nodes[-1]

    yield make
    for node in nodes:
        node.close()


@pytest.fixture
def node(made: Any) -> RecognitionNode:
    return made()


def worked_off(node: RecognitionNode) -> list[Any]:
    steps = []
    while (step := node.work(timeout=0.02)) is not None:
        steps.append(step)
    return steps


def send(bus: MemoryBus, topic: str, kind: str = EMPTY) -> None:
    empty = message(EMPTY, structure_needs_at_least_one_member=0)
    bus.advertise(topic, kind, COMMANDS)(packed(kind, empty))


def values(node: RecognitionNode) -> dict[str, Any]:
    return node.health.status(node.running, None, 0).values


def status(bus: MemoryBus, text: str, seconds: float = 6.0) -> Any:
    """The first diagnostics that say something."""
    until = time.monotonic() + seconds
    seen: list[str] = []
    while time.monotonic() < until:
        for told in bus.told("/diagnostics"):
            seen.append(told.status[0].message)
            if text in told.status[0].message:
                return told.status[0]
        time.sleep(0.05)
    raise AssertionError(f"nobody said {text!r}, but {sorted(set(seen))}")


def test_a_chair_is_named_and_everything_is_told(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(20):
        robot.drive(number)
    steps = worked_off(node)
    assert [step.outcome for step in steps] == [CLASSIFIED] * 20
    assert steps[-1].pose.prior == "odometry"
    answers = bus.told("/circumspect/detections")
    assert len(answers) == 20
    best = answers[-1].detections[0].results[0].hypothesis
    assert best.class_id == "chair"
    assert best.score == steps[-1].prediction.probability > 0.5
    assert answers[-1].header.frame_id == "circumspect_map"
    node.close()
    model, path = bus.told("/circumspect/model")[-1], bus.told("/circumspect/path")[-1]
    points = np.frombuffer(model.data.tobytes(), "<f4").reshape(-1, 6)
    assert len(points) == model.width > 1000
    np.testing.assert_allclose(np.linalg.norm(points[:, 3:], axis=1), 1, atol=1e-3)
    # The map lies where the odometry began, which is true here.
    _, frames = orbit()
    for stamped, (_, place) in ((path.poses[0], frames[0]), (path.poses[-1], frames[19])):
        found = stamped.pose.position
        assert np.hypot(found.x - place.x, found.y - place.y) < 0.02
    assert bus.told("/circumspect/next_view")[-1].header.frame_id == "circumspect_map"
    transform = bus.told("/tf")[-1].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "circumspect_map")
    assert abs(transform.transform.translation.x) < 0.02


def test_what_is_offered_and_wanted(bus: MemoryBus, node: RecognitionNode) -> None:
    below = {name: bus.offered[f"/circumspect/{name}"] for name in ("model", "path", "next_view")}
    assert below == {"model": (POINTS, LATEST), "path": (PATH, LATEST), "next_view": (POSE, LATEST)}
    assert bus.offered["/circumspect/detections"] == (DETECTIONS, ANSWERS)
    for topic in (DEPTH, INFO, "/odom", "/tf"):
        assert not bus.wanted[topic][1].reliable
    assert bus.wanted["/tf_static"][1].latched
    assert LATEST.latched


@pytest.mark.parametrize("odometry", [True, False], ids=["topic", "transforms"])
def test_odometry_of_a_topic_or_of_transforms(bus: MemoryBus, made: Any, odometry: bool) -> None:
    node = made(odometry="/odom" if odometry else "")
    robot = OrbitingRobot(bus, odometry=odometry)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    assert [step.pose.prior for step in worked_off(node)] == ["first frame"] + 2 * ["odometry"]


def test_depth_in_metres_is_the_same(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    frame, place = robot.frames[0]
    told = depth_message(frame.depth, 100.0, OPTICAL)
    told.encoding, told.step = "32FC1", 4 * told.width
    told.data = np.frombuffer(frame.depth.astype("<f4").tobytes(), np.uint8)
    robot.tell_place(100.0, place)
    robot.tell_info(camera_info(frame.camera, 100.0, OPTICAL))
    robot.tell_depth(told)
    assert [step.outcome for step in worked_off(node)] == [CLASSIFIED]


def test_given_poses_and_a_box(bus: MemoryBus, made: Any) -> None:
    box = (-0.6, -0.6, 0.02, 0.6, 0.6, 1.5)
    node = made(poses="given", map_frame="odom", odometry="", box=box)
    robot = OrbitingRobot(bus, odometry=False)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    steps = worked_off(node)
    assert [step.pose.prior for step in steps] == ["given"] * 3
    assert bus.told("/circumspect/detections")[-1].header.frame_id == "odom"


def test_stop_start_and_reset(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    assert len(worked_off(node)) == 1
    send(bus, "/circumspect/stop")
    node.work(0)
    robot.drive(1)
    assert not node.running
    assert worked_off(node) == []
    send(bus, "/circumspect/start")
    node.work(0)
    robot.drive(2)
    assert worked_off(node)[0].model.frames == 2
    send(bus, "/circumspect/reset")
    node.work(0)
    assert bus.told("/circumspect/model")[-1].width == 0
    assert bus.told("/circumspect/detections")[-1].detections == []
    assert bus.told("/circumspect/path")[-1].poses == []
    robot.drive(3)
    assert worked_off(node)[0].model.frames == 1


def test_it_may_wait_for_its_start(bus: MemoryBus, made: Any) -> None:
    node = made(autostart=False)
    robot = OrbitingRobot(bus)
    robot.stand()
    robot.drive(0)
    assert worked_off(node) == []
    send(bus, "/circumspect/start")
    node.work(0)
    robot.drive(1)
    assert len(worked_off(node)) == 1


def test_a_slow_classifier_drops_the_oldest_and_says_so(bus: MemoryBus, made: Any) -> None:
    node = made(queue=2)
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(6):
        robot.drive(number)
    stamps = [step.stamp for step in worked_off(node)]
    np.testing.assert_allclose(stamps, [100.8, 101.0])
    assert values(node)["frames taken"] == 6
    assert values(node)["frames dropped"] == 4


def test_the_rate_limits_what_is_taken(bus: MemoryBus, made: Any) -> None:
    node = made(rate=0.01)
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    assert len(worked_off(node)) == 1
    assert values(node)["depth heard"] == 3
    assert values(node)["frames dropped"] == 0


class Faulty(Classifier):
    """Breaks on the second grid."""

    def __init__(self, sound: Classifier) -> None:
        self._sound, self._count = sound, 0

    classes = property(lambda self: self._sound.classes)
    recipe = property(lambda self: self._sound.recipe)

    def classify(self, cloud: Any) -> Any:
        return self._sound.classify(cloud)

    def classify_grid(self, grid: Any) -> Any:
        self._count += 1
        if self._count == 2:
            raise ZeroDivisionError("on purpose")
        return self._sound.classify_grid(grid)


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
    assert [step.outcome for step in worked_off(node)] == [CLASSIFIED] * 2
    assert sum(1 for what in values(node) if what.startswith("left out: a pose")) == 2


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
    time.sleep(0.55)
    # The next message tells that enough time went by.
    robot.tell_info(camera_info(frame.camera, 105.0, OPTICAL))
    assert [step.pose.prior for step in worked_off(node)] == ["first frame", "constant velocity"]
    assert "by registration alone" in node.health.status(True, None, 0).text


def test_a_clock_that_is_set_back_begins_anew(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    worked_off(node)
    robot.drive(3, late=-50.0)  # the image at which it is noticed
    for number in range(4, 7):
        robot.drive(number, late=-50.0)
    steps = worked_off(node)
    assert [step.outcome for step in steps] == [CLASSIFIED] * 3
    assert steps[-1].model.frames == 3
    assert any(re.search(r"the clock leapt by -(49|50)\.", what) for what in values(node))


def test_a_clock_that_leaps_on_keeps_the_model(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    worked_off(node)
    for number in range(3, 6):
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
    assert [step.pose.prior for step in worked_off(node)][1:] == ["odometry"] * 3


def test_the_diagnostics_go_on_while_a_frame_takes_long(
    bus: MemoryBus, classifier: Classifier
) -> None:
    class Slow(Faulty):
        def classify_grid(self, grid: Any) -> Any:
            time.sleep(2.5)
            return self._sound.classify_grid(grid)

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
