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
from circumspect.ros.outgoing import PATH, POINTS, POSE
from circumspect.ros.recognition_node import RecognitionNode


def test_a_chair_is_named_and_everything_is_told(bus: MemoryBus, node: RecognitionNode) -> None:
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(20):
        robot.drive(number)
    steps = worked_off(node)
    assert [step.outcome for step in steps] == [FrameOutcome.CLASSIFIED] * 20
    assert steps[-1].pose.source == "odometry"
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


def retracted(told: Any) -> bool:
    """Whether a pose is of nothing."""
    place = told.pose.position
    return told.header.frame_id == "" and bool(np.isnan([place.x, place.y, place.z]).all())


@pytest.fixture
def driving(
    bus: MemoryBus, node: RecognitionNode, monkeypatch: pytest.MonkeyPatch
) -> OrbitingRobot:
    """A robot of which two frames were worked on; all that is known is told after each."""
    monkeypatch.setattr("circumspect.ros.announcer.EVERY", 0.0)
    robot = OrbitingRobot(bus)
    robot.stand()
    for number in range(2):
        robot.drive(number)
    worked_off(node)
    return robot


def test_a_next_view_that_is_none_any_more_is_retracted_once(
    bus: MemoryBus,
    node: RecognitionNode,
    driving: OrbitingRobot,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The topic is latched: who comes late would still be sent there."""
    views = [retracted(told) for told in bus.told("/circumspect/next_view")]
    assert views == [False, False]
    assert node.target is not None
    with monkeypatch.context() as patch:
        patch.setattr(NextViews, "advice", lambda *_: Finished("seen enough"))
        for number in range(2, 4):
            driving.drive(number)
        worked_off(node)
    assert [retracted(told) for told in bus.told("/circumspect/next_view")[2:]] == [True]
    assert node.target is None
    driving.drive(4)
    worked_off(node)
    for _ in range(2):
        send(bus, "/circumspect/reset")
        node.work(0)
    assert [retracted(told) for told in bus.told("/circumspect/next_view")[3:]] == [False, True]


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
def test_the_map_hangs_below_the_frame_that_the_odometry_names(
    bus: MemoryBus, made: Any, own: str, setting: str, odometry: bool, parent: str
) -> None:
    node = made(odometry="/odom" if odometry else "", odom_frame=setting)
    robot = OrbitingRobot(bus, odometry=odometry, odom_frame=own)
    robot.stand()
    for number in range(2):
        robot.drive(number)
    assert len(worked_off(node)) == 2
    told = [one for message in bus.told("/tf") for one in message.transforms]
    parents = {one.header.frame_id for one in told if one.child_frame_id == "circumspect_map"}
    assert parents == {parent}


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
    assert [step.outcome for step in worked_off(node)] == [FrameOutcome.CLASSIFIED]


def test_given_poses_and_a_box(bus: MemoryBus, made: Any) -> None:
    box = (-0.6, -0.6, 0.02, 0.6, 0.6, 1.5)
    node = made(poses="given", map_frame="odom", odometry="", box=box)
    robot = OrbitingRobot(bus, odometry=False)
    robot.stand()
    for number in range(3):
        robot.drive(number)
    steps = worked_off(node)
    assert [step.pose.source for step in steps] == ["given"] * 3
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


def test_an_answer_that_is_none_any_more_is_withdrawn_once(
    bus: MemoryBus,
    node: RecognitionNode,
    driving: OrbitingRobot,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What turns out to be wider than anything that has a name: who comes late would still hear it."""

    def too_wide(grids: ObjectGrids, *_: object) -> FrameOutcome:
        grids.grids = ()
        return FrameOutcome.TOO_WIDE

    monkeypatch.setattr(ObjectGrids, "_filled", too_wide)
    for number in range(2, 4):
        driving.drive(number)
    assert [step.outcome for step in worked_off(node)] == [FrameOutcome.TOO_WIDE] * 2
    told = [len(answer.detections) for answer in bus.told("/circumspect/detections")]
    assert told == [1, 1, 0]
    views = [retracted(view) for view in bus.told("/circumspect/next_view")]
    assert views == [False, False, True]
    assert node.target is None
    node.close()
    assert len(bus.told("/circumspect/detections")) == 3
