"""Clocks that leap in a bag, and the poses that its transforms give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bag_world import CAMERA, MOUNT, assert_same_pose, frame
from foreign_bags import COUNT, driven, mcap, robots_messages, without
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.recording import BagRecording, BagSettings, GivenPoses, open_recording
from circumspect.recording.bag import BagMessage
from circumspect.recording.frame_assembly import AssemblySettings, ClockError, FrameAssembly
from circumspect.recording.image_messages import camera_info, depth_message
from circumspect.recording.pose_messages import transform_message, transforms_message
from circumspect.recording.ros_types import TRANSFORMS
from circumspect.recording.topic_choice import ChosenTopics


def test_the_map_frame_gives_poses_if_asked_for(tmp_path: Path) -> None:
    T_map_odom = RigidTransform.from_components([3.0, 2.0, 0.0], Rotation.from_rotvec([0, 0, 0.7]))
    moved = transforms_message([transform_message(T_map_odom, 0.0, "map", "odom")])
    still = transforms_message([
        transform_message(RigidTransform.identity(), 0.0, "odom", "base_footprint")
    ])  # fmt: skip
    told = [("/tf", TRANSFORMS, 0.0, moved), ("/tf", TRANSFORMS, 0.0, still), *robots_messages()]
    path = mcap(tmp_path, told)
    poses = [one.T_map_camera for one in open_recording(path)]
    for pose in poses:
        assert pose is not None
        np.testing.assert_allclose(pose.as_matrix(), (T_map_odom * MOUNT).as_matrix(), atol=1e-12)
    first = [one.T_map_camera is None for one in open_recording(path, poses=GivenPoses.FIRST)]
    assert first == [False, *[True] * (COUNT - 1)]
    assert all(one.T_map_camera is None for one in open_recording(path, poses=GivenPoses.NONE))


def test_a_map_frame_that_nobody_knows_is_told_with_the_known_ones(tmp_path: Path) -> None:
    recording = open_recording(mcap(tmp_path, robots_messages()))
    assert isinstance(recording, BagRecording)
    with pytest.raises(
        InputError, match=r"'map' at 0\.000 s.* of: base_footprint, mast, xtion;.* --map-frame"
    ):
        next(recording.with_poses())
    known = BagSettings(map_frame="base_footprint")
    recording = open_recording(recording.path, settings=known)
    assert isinstance(recording, BagRecording)
    assert len(list(recording.with_poses())) == COUNT


def test_without_transforms_there_is_no_mount_unless_it_is_given(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/tf_static"))
    assert all(one.T_base_camera is None for one in open_recording(path))
    given = open_recording(path, settings=BagSettings(T_base_camera=MOUNT))
    assert_same_pose(next(iter(given)).T_base_camera, MOUNT)


def test_given_poses_are_those_of_the_image_not_of_the_last_transform(tmp_path: Path) -> None:
    """Frames wait for odometry; the robot drives on meanwhile."""
    told = [one for one in robots_messages() if one[0] != "/odom" or one[2] > 0.3]
    for k in range(100):
        T = driven(0.01 * k).as_transform()
        moved = transforms_message([transform_message(T, 0.01 * k, "map", "base_footprint")])
        told.append(("/tf", TRANSFORMS, 0.01 * k, moved))
    path = mcap(tmp_path, sorted(told, key=lambda one: one[2]))
    found = list(open_recording(path, poses=GivenPoses.ALL))
    assert len(found) == COUNT
    for one in found:
        assert one.T_map_camera is not None
        expected = driven(one.stamp).as_transform() * MOUNT
        np.testing.assert_allclose(one.T_map_camera.as_matrix(), expected.as_matrix(), atol=1e-6)


def test_after_a_leap_of_the_clock_the_rest_is_left_out(tmp_path: Path) -> None:
    told = robots_messages()
    images = [message for topic, _, _, message in told if topic.endswith("image_raw")]
    for message in images[4:]:
        message.header.stamp.sec += 3600
    recording = open_recording(mcap(tmp_path, told))
    assert len(list(recording)) == 4
    assert recording.skipped["the rest"].startswith("the clock leapt by +3600.0 s")


def test_clocks_that_are_set_back_together_are_told_and_nothing_piles_up() -> None:
    """Nothing may wait for a time that comes only after a minute."""
    topics = ChosenTopics("/depth", "/camera_info", None, "/odom", ())
    assembly = FrameAssembly(topics, AssemblySettings())
    leaps, frames = [], 0
    for number in range(400):
        stamp = 100.0 + 0.1 * number - (60 if number >= 200 else 0)
        image = depth_message(frame(0).depth, stamp, "xtion")
        info = camera_info(CAMERA, stamp, "xtion")
        for topic, message in ((topics.info, info), (topics.depth, image)):
            try:
                told = BagMessage(topic, round(1e9 * stamp), message)
                frames += len(list(assembly.heard(told)))
            except ClockError as error:
                leaps.append(round(error.leap, 3))
                assembly.restart()
    assert leaps == [-59.9]
    assert frames > 380
