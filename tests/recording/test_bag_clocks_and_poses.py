"""Clock jumps in a bag, and poses from its transforms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bag_world import CAMERA, MOUNT, assert_same_pose, frame
from foreign_bags import COUNT, Write, driven, mcap, robots_messages, ros1, without
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.recording import BagRecording, BagSettings, open_recording
from circumspect.recording.bag import BagMessage
from circumspect.recording.frame_assembly import AssemblySettings, ClockError, FrameAssembly
from circumspect.recording.image_messages import camera_info, depth_message
from circumspect.recording.pose_messages import (
    odometry_message,
    transform_message,
    transforms_message,
)
from circumspect.recording.ros_types import TRANSFORMS
from circumspect.recording.topic_choice import ChosenTopics
from circumspect.sensing import Odometry


def test_the_map_frame_gives_poses_on_request(tmp_path: Path) -> None:
    T_map_odom = RigidTransform.from_components([3.0, 2.0, 0.0], Rotation.from_rotvec([0, 0, 0.7]))
    moved = transforms_message([transform_message(T_map_odom, 0.0, "map", "odom")])
    still = transforms_message([
        transform_message(RigidTransform.identity(), 0.0, "odom", "base_footprint")
    ])  # fmt: skip
    messages = [
        ("/tf", TRANSFORMS, 0.0, moved),
        ("/tf", TRANSFORMS, 0.0, still),
        *robots_messages(),
    ]
    path = mcap(tmp_path, messages)
    poses = [one.T_map_camera for one in open_recording(path)]
    for pose in poses:
        assert pose is not None
        np.testing.assert_allclose(pose.as_matrix(), (T_map_odom * MOUNT).as_matrix(), atol=1e-12)
    assert all(one.T_map_camera is None for one in open_recording(path, poses=False))


def test_an_unknown_map_frame_is_refused_with_the_known_ones(tmp_path: Path) -> None:
    recording = open_recording(mcap(tmp_path, robots_messages()))
    assert isinstance(recording, BagRecording)
    with pytest.raises(
        InputError,
        match=r"in the frame 'map' at .* frames: base_footprint, mast, xtion;.* --map-frame",
    ):
        next(recording.with_poses())
    assert not recording.skipped, "one line is enough"
    known = BagSettings(map_frame="base_footprint")
    recording = open_recording(recording.path, settings=known)
    assert isinstance(recording, BagRecording)
    assert len(list(recording.with_poses())) == COUNT


def test_without_transforms_there_is_no_mount_unless_it_is_given(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/tf_static"))
    assert all(one.T_base_camera is None for one in open_recording(path))
    with pytest.raises(InputError, match=r"mount of the camera .* frames: none; .* --mount"):
        next(open_recording(path).from_first_pose())
    given = open_recording(path, settings=BagSettings(T_base_camera=MOUNT))
    assert_same_pose(next(iter(given)).T_base_camera, MOUNT)


@pytest.mark.parametrize("write", [mcap, ros1])
def test_frames_before_the_first_mount_are_skipped(tmp_path: Path, write: Write) -> None:
    messages = [
        ("/tf", *one[1:2], 0.15, one[3]) if one[0] == "/tf_static" else one
        for one in robots_messages()
    ]
    recording = open_recording(write(tmp_path, sorted(messages, key=lambda one: one[2])))
    assert [one.stamp for one in recording.from_first_pose()] == pytest.approx([0.2, 0.3, 0.4, 0.5])
    assert recording.skipped["frames without a pose"].startswith("2: no transform gives the ")
    assert len(list(recording)) == COUNT, "without a need for the mount all frames come"
    assert not recording.skipped


def test_frames_before_the_first_given_pose_are_skipped(tmp_path: Path) -> None:
    messages = robots_messages()
    for stamp in (0.25, 0.35, 0.45):
        moved = transform_message(driven(stamp).as_transform(), stamp, "map", "base_footprint")
        messages.append(("/tf", TRANSFORMS, stamp, transforms_message([moved])))
    path = mcap(tmp_path, sorted(messages, key=lambda one: one[2]))
    recording = open_recording(path)
    assert isinstance(recording, BagRecording)
    found = list(recording.with_poses())
    early = COUNT - len(found)
    assert 1 < early < COUNT
    assert all(one.T_map_camera is not None for one in found)
    assert recording.skipped["frames without a pose"].startswith(f"{early}: ")


@pytest.mark.parametrize("write", [mcap, ros1])
def test_frames_after_the_localization_stopped_are_skipped_and_counted(
    tmp_path: Path, write: Write
) -> None:
    """Its last pose would hold for all of them while the robot drives on."""
    messages = robots_messages()
    for stamp in (0.15, 0.1, 0.05, 0.0):
        moved = transform_message(driven(stamp).as_transform(), stamp, "map", "base_footprint")
        messages.insert(0, ("/tf", TRANSFORMS, stamp, transforms_message([moved])))
    recording = open_recording(write(tmp_path, sorted(messages, key=lambda one: one[2])))
    assert isinstance(recording, BagRecording)
    assert [one.stamp for one in recording.with_poses()] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert recording.skipped["frames without a pose"].startswith("2: no transform gives the ")


def test_a_replaced_static_transform_is_no_motion(tmp_path: Path) -> None:
    messages, lower = robots_messages(), RigidTransform.from_translation([0.0, 0.0, 0.4])
    mast = transform_message(lower, 0.01, "base_footprint", "mast")
    messages.insert(1, ("/tf_static", TRANSFORMS, 0.01, transforms_message([mast])))
    recording = open_recording(mcap(tmp_path, sorted(messages, key=lambda one: one[2])))
    assert all(one.T_base_camera is not None for one in recording)


def test_one_pose_is_enough_without_a_mount(tmp_path: Path) -> None:
    messages = without(robots_messages(), "/tf_static")
    T_map_camera = transform_message(MOUNT, 0.0, "map", "xtion")
    messages.insert(0, ("/tf", TRANSFORMS, 0.0, transforms_message([T_map_camera])))
    recording = open_recording(mcap(tmp_path, messages))
    assert len(list(recording.from_first_pose())) == COUNT


def test_given_poses_are_interpolated_at_the_stamp_of_the_image(tmp_path: Path) -> None:
    """Frames wait for odometry while the robot drives on."""
    messages = [one for one in robots_messages() if one[0] != "/odom" or one[2] > 0.3]
    for k in range(100):
        T = driven(0.01 * k).as_transform()
        moved = transforms_message([transform_message(T, 0.01 * k, "map", "base_footprint")])
        messages.append(("/tf", TRANSFORMS, 0.01 * k, moved))
    path = mcap(tmp_path, sorted(messages, key=lambda one: one[2]))
    found = list(open_recording(path))
    assert len(found) == COUNT
    for one in found:
        assert one.T_map_camera is not None
        expected = driven(one.stamp).as_transform() * MOUNT
        np.testing.assert_allclose(one.T_map_camera.as_matrix(), expected.as_matrix(), atol=1e-6)


def test_frames_after_a_clock_jump_are_skipped(tmp_path: Path) -> None:
    messages = robots_messages()
    images = [message for topic, _, _, message in messages if topic.endswith("image_raw")]
    for message in images[4:]:
        message.header.stamp.sec += 3600
    recording = open_recording(mcap(tmp_path, messages))
    assert len(list(recording)) == 4
    assert recording.skipped["the rest"].startswith("the clock jumped by +3600.0 s")


def stamps_of_frames(stamps: list[float], arrivals: list[float]) -> list[float]:
    """Stamps of the frames assembled from depth images with these stamps and arrival times."""
    topics = ChosenTopics("/depth", None, None, None, ())
    assembly = FrameAssembly(topics, AssemblySettings(camera=CAMERA))
    found = []
    for stamp, arrival in zip(stamps, arrivals, strict=True):
        image = depth_message(frame(0).depth, stamp, "xtion")
        found += assembly.on_message(BagMessage("/depth", round(1e9 * arrival), image))
    return [one.stamp for one in found]


@given(
    st.lists(st.tuples(st.floats(0, 5), st.floats(0, 1e4)), min_size=1, max_size=9),
    st.floats(0, 1e6),
)
def test_a_paused_source_is_no_clock_jump(steps: list[tuple[float, float]], start: float) -> None:
    stamps = start + np.cumsum([step for step, _ in steps])
    arrivals = np.cumsum([step + pause for step, pause in steps])
    assert stamps_of_frames(list(stamps), list(arrivals)) == pytest.approx(list(stamps), abs=1e-6)


@pytest.mark.parametrize(
    ("stamps", "arrivals", "jump_s"),
    [
        ([100.0, 100.1, 98.8, 98.9], [0.0, 0.1, 0.2, 0.3], -1.2),
        ([100.0, 100.1, 98.8, 98.9], [0.0, 0.1, 60.0, 60.1], -1.2),
        ([100.0, 100.1, 160.2, 160.3], [0.0, 0.1, 50.2, 50.3], 10.0),
        ([100.0, 100.1, 106.0, 106.1], [0.0, 20.1, 20.2, 20.3], 5.8),
    ],
)
def test_stamps_that_fall_or_run_ahead_are_a_clock_jump(
    stamps: list[float], arrivals: list[float], jump_s: float
) -> None:
    with pytest.raises(ClockError) as error:
        stamps_of_frames(stamps, arrivals)
    assert error.value.jump_s == pytest.approx(jump_s)


@pytest.mark.parametrize("wrong", [0.0, 98.0, 170.0, 1e9])
def test_a_single_wrong_stamp_is_no_clock_jump(wrong: float) -> None:
    stamps = [100.0, 100.1, wrong, 100.3, 100.4, wrong, 100.6]
    arrivals = [0.1 * number for number in range(7)]
    kept = [stamp for stamp in stamps if stamp != wrong]
    assert stamps_of_frames(stamps, arrivals) == pytest.approx(kept)


def test_odometry_of_a_skipped_image_is_skipped() -> None:
    topics = ChosenTopics("/depth", None, None, "/odom", ())
    assembly = FrameAssembly(topics, AssemblySettings(camera=CAMERA, synchronous=True))
    found = []
    for number, (stamp, with_odometry) in enumerate([(100.0, True), (0.0, True), (100.2, False)]):
        if with_odometry:
            messages = odometry_message(Odometry(stamp, driven(stamp)), "odom", "base")
            found += assembly.on_message(BagMessage("/odom", number * 10**8, messages))
        image = depth_message(frame(0).depth, stamp, "xtion")
        found += assembly.on_message(BagMessage("/depth", number * 10**8, image))
    assert [one.stamp for one in found] == [100.0, 100.2]
    assert [one.odometry is None for one in found] == [False, True]


def test_two_different_wrong_stamps_are_no_clock_jump() -> None:
    stamps, arrivals = [100.0, 0.0, 900.0, 100.3], [0.0, 0.1, 0.2, 0.3]
    assert stamps_of_frames(stamps, arrivals) == pytest.approx([100.0, 100.3])


def test_images_skipped_for_their_stamps_are_reported(tmp_path: Path) -> None:
    messages = robots_messages()
    images = [message for topic, _, _, message in messages if topic.endswith("image_raw")]
    images[2].header.stamp.sec += 3600
    recording = open_recording(mcap(tmp_path, messages))
    assert len(list(recording)) == COUNT - 1
    assert list(recording.skipped.values()) == ["its stamp jumped by +3600.0 s"]


def test_a_bag_of_a_source_that_was_paused_is_replayed_to_its_end(tmp_path: Path) -> None:
    messages = [(*one[:2], one[2] + 60 * (one[2] > 0.25), one[3]) for one in robots_messages()]
    recording = open_recording(mcap(tmp_path, messages))
    assert [one.stamp for one in recording] == pytest.approx(0.1 * np.arange(COUNT))
    assert not recording.skipped


def test_clocks_set_back_together_are_reported_and_no_messages_pile_up() -> None:
    """No message waits for stamps that come only a minute later."""
    topics = ChosenTopics("/depth", "/camera_info", None, "/odom", ())
    assembly = FrameAssembly(topics, AssemblySettings())
    jumps, frames = [], 0
    for number in range(400):
        stamp = 100.0 + 0.1 * number - (60 if number >= 200 else 0)
        image = depth_message(frame(0).depth, stamp, "xtion")
        info = camera_info(CAMERA, stamp, "xtion")
        for topic, message in ((topics.info, info), (topics.depth, image)):
            try:
                messages = BagMessage(topic, round(1e9 * stamp), message)
                frames += len(list(assembly.on_message(messages)))
            except ClockError as error:
                jumps.append(round(error.jump_s, 3))
                assembly.restart()
    assert jumps == [-59.8]
    assert frames > 380
