"""The node over a bus in memory: all of its logic, none of the network."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from node_world import send, values, worked_off
from orbiting_robot import DEPTH, INFO, OPTICAL, MemoryBus, OrbitingRobot, orbit

from circumspect.planning import Finished
from circumspect.recognition import FrameOutcome
from circumspect.recognition.object_grids import ObjectGrids
from circumspect.recording.image_messages import camera_info, depth_message
from circumspect.recording.ros_types import DETECTIONS
from circumspect.ros.middleware import ANSWERS, LATEST
from circumspect.ros.next_views import NextViews
from circumspect.ros.output_messages import PATH, POINTS, POSE
from circumspect.ros.recognition_node import RecognitionNode


def test_a_chair_is_recognised_and_all_results_are_published(
    bus: MemoryBus, node: RecognitionNode
) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(20):
        robot.publish_frame(number)
    steps = worked_off(node)
    assert [step.outcome for step in steps] == [FrameOutcome.CLASSIFIED] * 20
    assert steps[-1].pose.source == "odometry"
    answers = bus.received("/circumspect/detections")
    assert len(answers) == 20
    best = answers[-1].detections[0].results[0].hypothesis
    assert best.class_id == "chair"
    assert best.score == steps[-1].prediction.probability > 0.5
    assert answers[-1].header.frame_id == "circumspect_map"
    node.close()
    model, path = bus.received("/circumspect/model")[-1], bus.received("/circumspect/path")[-1]
    points = np.frombuffer(model.data.tobytes(), "<f4").reshape(-1, 6)
    assert len(points) == model.width > 1000
    np.testing.assert_allclose(np.linalg.norm(points[:, 3:], axis=1), 1, atol=1e-3)
    # The map starts at the origin of the odometry, which equals the world here.
    _, frames = orbit()
    for stamped, (_, place) in ((path.poses[0], frames[0]), (path.poses[-1], frames[19])):
        found = stamped.pose.position
        assert np.hypot(found.x - place.x, found.y - place.y) < 0.02
    assert bus.received("/circumspect/next_view")[-1].header.frame_id == "circumspect_map"
    transform = bus.received("/tf")[-1].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "circumspect_map")
    assert abs(transform.transform.translation.x) < 0.02


def retracted(received: Any) -> bool:
    """Whether a pose withdraws the one before: no frame, not finite."""
    place = received.pose.position
    return received.header.frame_id == "" and bool(np.isnan([place.x, place.y, place.z]).all())


@pytest.fixture
def driving(
    bus: MemoryBus, node: RecognitionNode, monkeypatch: pytest.MonkeyPatch
) -> OrbitingRobot:
    """A robot after two processed frames; the node publishes its results after each."""
    monkeypatch.setattr("circumspect.ros.result_publisher.PUBLISH_INTERVAL_S", 0.0)
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(2):
        robot.publish_frame(number)
    worked_off(node)
    return robot


def test_a_next_view_that_no_longer_holds_is_withdrawn_once(
    bus: MemoryBus,
    node: RecognitionNode,
    driving: OrbitingRobot,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The topic is latched: late subscribers would still receive the old view."""
    views = [retracted(received) for received in bus.received("/circumspect/next_view")]
    assert views == [False, False]
    assert node.target is not None
    with monkeypatch.context() as patch:
        patch.setattr(NextViews, "next_view", lambda *_: Finished("seen enough"))
        for number in range(2, 4):
            driving.publish_frame(number)
        worked_off(node)
    assert [retracted(received) for received in bus.received("/circumspect/next_view")[2:]] == [
        True
    ]
    assert node.target is None
    driving.publish_frame(4)
    worked_off(node)
    for _ in range(2):
        send(bus, "/circumspect/reset")
        node.work(0)
    assert [retracted(received) for received in bus.received("/circumspect/next_view")[3:]] == [
        False,
        True,
    ]


def test_publishers_subscribers_and_their_qualities(bus: MemoryBus, node: RecognitionNode) -> None:
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
    robot.publish_mount()
    for number in range(3):
        robot.publish_frame(number)
    assert [step.pose.source for step in worked_off(node)] == ["initial pose"] + 2 * ["odometry"]


@pytest.mark.parametrize(
    ("own", "setting", "odometry", "parent"),
    [
        ("robot1/odom", "odom", True, "robot1/odom"),
        ("/odom_combined", "odom", True, "odom_combined"),
        ("", "wheels", True, "wheels"),
        ("wheels", "wheels", False, "wheels"),
    ],
)
def test_the_map_is_a_child_of_the_odometry_frame(
    bus: MemoryBus, made: Any, own: str, setting: str, odometry: bool, parent: str
) -> None:
    node = made(odometry="/odom" if odometry else "", odom_frame=setting)
    robot = OrbitingRobot(bus, odometry=odometry, odom_frame=own)
    robot.publish_mount()
    for number in range(2):
        robot.publish_frame(number)
    assert len(worked_off(node)) == 2
    received = [one for message in bus.received("/tf") for one in message.transforms]
    parents = {one.header.frame_id for one in received if one.child_frame_id == "circumspect_map"}
    assert parents == {parent}


def test_depth_in_metres_is_the_same(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    frame, place = robot.frames[0]
    received = depth_message(frame.depth, 100.0, OPTICAL)
    received.encoding, received.step = "32FC1", 4 * received.width
    received.data = np.frombuffer(frame.depth.astype("<f4").tobytes(), np.uint8)
    robot.publish_place(100.0, place)
    robot.publish_info(camera_info(frame.camera, 100.0, OPTICAL))
    robot.publish_depth(received)
    assert [step.outcome for step in worked_off(node)] == [FrameOutcome.CLASSIFIED]


def test_given_poses_and_a_box(bus: MemoryBus, made: Any) -> None:
    box = (-0.6, -0.6, 0.02, 0.6, 0.6, 1.5)
    node = made(poses="given", map_frame="odom", odometry="", box=box)
    robot = OrbitingRobot(bus, odometry=False)
    robot.publish_mount()
    for number in range(3):
        robot.publish_frame(number)
    steps = worked_off(node)
    assert [step.pose.source for step in steps] == ["given"] * 3
    assert bus.received("/circumspect/detections")[-1].header.frame_id == "odom"


def test_stop_start_and_reset(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    assert len(worked_off(node)) == 1
    send(bus, "/circumspect/stop")
    node.work(0)
    robot.publish_frame(1)
    assert not node.running
    assert worked_off(node) == []
    send(bus, "/circumspect/start")
    node.work(0)
    robot.publish_frame(2)
    assert worked_off(node)[0].model.frames == 2
    send(bus, "/circumspect/reset")
    node.work(0)
    assert bus.received("/circumspect/model")[-1].width == 0
    assert bus.received("/circumspect/detections")[-1].detections == []
    assert bus.received("/circumspect/path")[-1].poses == []
    robot.publish_frame(3)
    assert worked_off(node)[0].model.frames == 1


def test_without_autostart_the_node_waits_for_start(bus: MemoryBus, made: Any) -> None:
    node = made(autostart=False)
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    robot.publish_frame(0)
    assert worked_off(node) == []
    send(bus, "/circumspect/start")
    node.work(0)
    robot.publish_frame(1)
    assert len(worked_off(node)) == 1


def test_a_slow_classifier_drops_the_oldest_frames_and_reports_it(
    bus: MemoryBus, made: Any
) -> None:
    node = made(queue=2)
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(6):
        robot.publish_frame(number)
    stamps = [step.stamp for step in worked_off(node)]
    np.testing.assert_allclose(stamps, [100.8, 101.0])
    assert values(node)["frames taken"] == 6
    assert values(node)["frames dropped"] == 4


def test_the_rate_limits_the_taken_frames(bus: MemoryBus, made: Any) -> None:
    node = made(rate=0.01)
    robot = OrbitingRobot(bus)
    robot.publish_mount()
    for number in range(3):
        robot.publish_frame(number)
    assert len(worked_off(node)) == 1
    assert values(node)["depth received"] == 3
    assert values(node)["frames dropped"] == 0


def test_an_answer_that_no_longer_holds_is_withdrawn_once(
    bus: MemoryBus,
    node: RecognitionNode,
    driving: OrbitingRobot,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The object turns out too wide; late subscribers would still receive the old answer."""

    def too_wide(grids: ObjectGrids, *_: object) -> FrameOutcome:
        grids.grids = ()
        return FrameOutcome.TOO_WIDE

    monkeypatch.setattr(ObjectGrids, "_filled", too_wide)
    for number in range(2, 4):
        driving.publish_frame(number)
    assert [step.outcome for step in worked_off(node)] == [FrameOutcome.TOO_WIDE] * 2
    received = [len(answer.detections) for answer in bus.received("/circumspect/detections")]
    assert received == [1, 1, 0]
    views = [retracted(view) for view in bus.received("/circumspect/next_view")]
    assert views == [False, False, True]
    assert node.target is None
    node.close()
    assert len(bus.received("/circumspect/detections")) == 3
