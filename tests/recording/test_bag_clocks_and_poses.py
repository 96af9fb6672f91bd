"""Clocks that leap in a bag, and the poses that its transforms give."""

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
    assert all(one.T_map_camera is None for one in open_recording(path, poses=False))


def test_a_map_frame_that_nobody_knows_is_told_with_the_known_ones(tmp_path: Path) -> None:
    recording = open_recording(mcap(tmp_path, robots_messages()))
    assert isinstance(recording, BagRecording)
    with pytest.raises(
        InputError,
        match=r"in the frame 'map' when .* of: base_footprint, mast, xtion;.* --map-frame",
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
    with pytest.raises(InputError, match=r"mounted on the robot when .* tell of: none; .* --mount"):
        next(open_recording(path).placed())
    given = open_recording(path, settings=BagSettings(T_base_camera=MOUNT))
    assert_same_pose(next(iter(given)).T_base_camera, MOUNT)


@pytest.mark.parametrize("write", [mcap, ros1])
def test_frames_before_the_first_mount_are_left_out_of_a_replay(
    tmp_path: Path, write: Write
) -> None:
    told = [
        ("/tf", *one[1:2], 0.15, one[3]) if one[0] == "/tf_static" else one
        for one in robots_messages()
    ]
    recording = open_recording(write(tmp_path, sorted(told, key=lambda one: one[2])))
    assert [one.stamp for one in recording.placed()] == pytest.approx([0.2, 0.3, 0.4, 0.5])
    assert recording.skipped["frames without a place"].startswith("2, for no transforms told where")
    assert len(list(recording)) == COUNT, "who does not need the mount gets them all"
    assert not recording.skipped


def test_frames_before_the_first_pose_are_left_out_where_poses_are_given(tmp_path: Path) -> None:
    told = robots_messages()
    for stamp in (0.25, 0.35, 0.45):
        moved = transform_message(driven(stamp).as_transform(), stamp, "map", "base_footprint")
        told.append(("/tf", TRANSFORMS, stamp, transforms_message([moved])))
    path = mcap(tmp_path, sorted(told, key=lambda one: one[2]))
    recording = open_recording(path)
    assert isinstance(recording, BagRecording)
    found = list(recording.with_poses())
    early = COUNT - len(found)
    assert 1 < early < COUNT
    assert all(one.T_map_camera is not None for one in found)
    assert recording.skipped["frames without a place"].startswith(f"{early}, ")


@pytest.mark.parametrize("write", [mcap, ros1])
def test_frames_after_a_localization_died_are_left_out_and_counted(
    tmp_path: Path, write: Write
) -> None:
    """Its last word would put them all in one place while the robot drives on."""
    told = robots_messages()
    for stamp in (0.15, 0.1, 0.05, 0.0):
        moved = transform_message(driven(stamp).as_transform(), stamp, "map", "base_footprint")
        told.insert(0, ("/tf", TRANSFORMS, stamp, transforms_message([moved])))
    recording = open_recording(write(tmp_path, sorted(told, key=lambda one: one[2])))
    assert isinstance(recording, BagRecording)
    assert [one.stamp for one in recording.with_poses()] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert recording.skipped["frames without a place"].startswith("2, for no transforms told where")


def test_static_transforms_that_are_told_anew_are_no_motion(tmp_path: Path) -> None:
    told, lower = robots_messages(), RigidTransform.from_translation([0.0, 0.0, 0.4])
    mast = transform_message(lower, 0.01, "base_footprint", "mast")
    told.insert(1, ("/tf_static", TRANSFORMS, 0.01, transforms_message([mast])))
    recording = open_recording(mcap(tmp_path, sorted(told, key=lambda one: one[2])))
    assert all(one.T_base_camera is not None for one in recording)


def test_one_pose_is_enough_without_a_mount(tmp_path: Path) -> None:
    told = without(robots_messages(), "/tf_static")
    T_map_camera = transform_message(MOUNT, 0.0, "map", "xtion")
    told.insert(0, ("/tf", TRANSFORMS, 0.0, transforms_message([T_map_camera])))
    recording = open_recording(mcap(tmp_path, told))
    assert len(list(recording.placed())) == COUNT


def test_given_poses_are_those_of_the_image_not_of_the_last_transform(tmp_path: Path) -> None:
    """Frames wait for odometry; the robot drives on meanwhile."""
    told = [one for one in robots_messages() if one[0] != "/odom" or one[2] > 0.3]
    for k in range(100):
        T = driven(0.01 * k).as_transform()
        moved = transforms_message([transform_message(T, 0.01 * k, "map", "base_footprint")])
        told.append(("/tf", TRANSFORMS, 0.01 * k, moved))
    path = mcap(tmp_path, sorted(told, key=lambda one: one[2]))
    found = list(open_recording(path))
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


def heard_at(stamps: list[float], arrivals: list[float]) -> list[float]:
    """The frames that come of depth images with some stamps, heard at some times."""
    topics = ChosenTopics("/depth", None, None, None, ())
    assembly = FrameAssembly(topics, AssemblySettings(camera=CAMERA))
    found = []
    for stamp, arrival in zip(stamps, arrivals, strict=True):
        image = depth_message(frame(0).depth, stamp, "xtion")
        found += assembly.heard(BagMessage("/depth", round(1e9 * arrival), image))
    return [one.stamp for one in found]


@given(
    st.lists(st.tuples(st.floats(0, 5), st.floats(0, 1e4)), min_size=1, max_size=9),
    st.floats(0, 1e6),
)
def test_a_source_that_pauses_goes_on_where_it_was(
    steps: list[tuple[float, float]], start: float
) -> None:
    stamps = start + np.cumsum([step for step, _ in steps])
    arrivals = np.cumsum([step + pause for step, pause in steps])
    assert heard_at(list(stamps), list(arrivals)) == pytest.approx(list(stamps), abs=1e-6)


@pytest.mark.parametrize(
    ("stamps", "arrivals", "leap"),
    [
        ([100.0, 100.1, 98.8, 98.9], [0.0, 0.1, 0.2, 0.3], -1.2),
        ([100.0, 100.1, 98.8, 98.9], [0.0, 0.1, 60.0, 60.1], -1.2),
        ([100.0, 100.1, 160.2, 160.3], [0.0, 0.1, 50.2, 50.3], 10.0),
        ([100.0, 100.1, 106.0, 106.1], [0.0, 20.1, 20.2, 20.3], 5.8),
    ],
)
def test_stamps_that_fall_or_run_ahead_are_a_leap(
    stamps: list[float], arrivals: list[float], leap: float
) -> None:
    with pytest.raises(ClockError) as error:
        heard_at(stamps, arrivals)
    assert error.value.leap == pytest.approx(leap)


@pytest.mark.parametrize("wrong", [0.0, 98.0, 170.0, 1e9])
def test_a_single_wrong_stamp_is_no_leap(wrong: float) -> None:
    stamps = [100.0, 100.1, wrong, 100.3, 100.4, wrong, 100.6]
    arrivals = [0.1 * number for number in range(7)]
    kept = [stamp for stamp in stamps if stamp != wrong]
    assert heard_at(stamps, arrivals) == pytest.approx(kept)


def test_odometry_of_an_image_that_is_left_out_goes_with_it() -> None:
    topics = ChosenTopics("/depth", None, None, "/odom", ())
    assembly = FrameAssembly(topics, AssemblySettings(camera=CAMERA, synchronous=True))
    found = []
    for number, (stamp, tells) in enumerate([(100.0, True), (0.0, True), (100.2, False)]):
        if tells:
            told = odometry_message(Odometry(stamp, driven(stamp)), "odom", "base")
            found += assembly.heard(BagMessage("/odom", number * 10**8, told))
        image = depth_message(frame(0).depth, stamp, "xtion")
        found += assembly.heard(BagMessage("/depth", number * 10**8, image))
    assert [one.stamp for one in found] == [100.0, 100.2]
    assert [one.odometry is None for one in found] == [False, True]


def test_two_wrong_stamps_that_differ_are_no_leap() -> None:
    stamps, arrivals = [100.0, 0.0, 900.0, 100.3], [0.0, 0.1, 0.2, 0.3]
    assert heard_at(stamps, arrivals) == pytest.approx([100.0, 100.3])


def test_what_is_left_out_of_a_bag_for_its_stamp_is_told(tmp_path: Path) -> None:
    told = robots_messages()
    images = [message for topic, _, _, message in told if topic.endswith("image_raw")]
    images[2].header.stamp.sec += 3600
    recording = open_recording(mcap(tmp_path, told))
    assert len(list(recording)) == COUNT - 1
    assert list(recording.skipped.values()) == ["its stamp is +3600.0 s off"]


def test_a_bag_of_a_source_that_was_paused_is_replayed_to_its_end(tmp_path: Path) -> None:
    told = [(*one[:2], one[2] + 60 * (one[2] > 0.25), one[3]) for one in robots_messages()]
    recording = open_recording(mcap(tmp_path, told))
    assert [one.stamp for one in recording] == pytest.approx(0.1 * np.arange(COUNT))
    assert not recording.skipped


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
    assert leaps == [-59.8]
    assert frames > 380
