"""Bags of other robots: late or invalid CameraInfo, no stamps, late static transforms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bag_world import CAMERA, frame
from foreign_bags import COUNT, TimedMessage, Write, driven, mcap, robots_messages, ros1

from circumspect.errors import InputError
from circumspect.recording import BagRecording, BagSettings, open_bag, open_recording
from circumspect.recording.image_messages import colour_message, depth_message
from circumspect.recording.ros_types import CAMERA_INFO, IMAGE
from circumspect.recording.topic_choice import TopicNames, choose_topics

INFO = "/camera/depth/camera_info"


def many_images(count: int) -> list[TimedMessage]:
    """More images than ever wait."""
    messages = [one for one in robots_messages() if one[0] == "/tf_static"]
    for number in range(count):
        stamp = 0.05 * number
        depth = depth_message(frame(number).depth, stamp, "xtion")
        messages.append(("/camera/depth/image_raw", IMAGE, stamp, depth))
    return messages


def info() -> TimedMessage:
    return next(one for one in robots_messages() if one[1] == CAMERA_INFO)


@pytest.mark.parametrize("write", [mcap, ros1])
def test_a_camera_info_that_comes_once_after_all_images_is_used(
    tmp_path: Path, write: Write
) -> None:
    messages = [*many_images(60), (INFO, CAMERA_INFO, 5.0, info()[3])]
    recording = open_recording(write(tmp_path, messages))
    found = list(recording)
    assert len(found) == 60
    assert {one.camera for one in found} == {CAMERA}
    assert not recording.skipped


@pytest.mark.parametrize("good", [0, 1])
def test_a_camera_info_of_zeros_is_named_unless_a_good_one_follows(
    tmp_path: Path, good: int
) -> None:
    messages = robots_messages()
    infos = [message for _, kind, _, message in messages if kind == CAMERA_INFO]
    for message in infos[: len(infos) - good]:
        message.k[:], message.p[:] = 0, 0
    recording = open_recording(mcap(tmp_path, messages))
    if good:
        assert len(list(recording)) == COUNT
        return
    with pytest.raises(
        InputError, match=rf"{INFO}: the CameraInfo is all zero: .*--intrinsics FX FY CX CY"
    ):
        list(recording)


def test_a_static_transform_that_is_recorded_late_holds_for_all_images(tmp_path: Path) -> None:
    messages = [
        (*one[:2], 0.45 if one[0] == "/tf_static" else one[2], one[3]) for one in robots_messages()
    ]
    recording = open_recording(mcap(tmp_path, sorted(messages, key=lambda one: one[2])))
    assert len(list(recording.from_first_pose())) == COUNT
    assert not recording.skipped


def without_stamps(
    messages: list[TimedMessage], topic: str, log_shift: float
) -> list[TimedMessage]:
    """The messages of a driver that sets no stamps, with log times on another clock."""
    for name, _, _, message in messages:
        if name == topic:
            message.header.stamp.sec = message.header.stamp.nanosec = 0
    return [(*one[:2], one[2] + log_shift, one[3]) for one in messages]


@pytest.mark.parametrize("topic", ["/camera/depth/image_raw", "/odom"])
def test_zero_stamps_are_replaced_by_the_log_times_and_reported_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, topic: str
) -> None:
    recording = open_recording(mcap(tmp_path, without_stamps(robots_messages(), topic, 1000.0)))
    found = list(recording)
    assert len(found) == COUNT
    start = 1000.0 if topic != "/odom" else 0.0
    assert [one.stamp for one in found] == pytest.approx(start + 0.1 * np.arange(COUNT))
    for number, one in enumerate(found):
        assert one.odometry is not None
        assert one.odometry.T_odom_base.xy == pytest.approx(driven(0.1 * number).xy, abs=1e-4)
    assert caplog.text.count("are zero; the bag's log times are used") == 1
    assert topic in caplog.text


def test_nan_in_the_covariance_of_odometry_keeps_the_pose(tmp_path: Path) -> None:
    messages = robots_messages()
    for topic, _, _, message in messages:
        if topic == "/odom":
            message.pose.covariance[:] = np.nan
    for one in open_recording(mcap(tmp_path, messages)):
        assert one.odometry is not None
        assert one.odometry.T_odom_base.xy == pytest.approx(driven(one.stamp).xy, abs=1e-9)
        np.testing.assert_array_equal(one.odometry.covariance, np.zeros((3, 3)))


def test_repeated_warnings_are_logged_once_with_their_count(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    messages = robots_messages()
    for topic, _, _, message in messages:
        if topic == "/odom":
            message.pose.pose.position.x = np.nan
    assert len(list(open_recording(mcap(tmp_path, messages)))) == COUNT
    assert caplog.text.count("message on /odom skipped") == 2, "the first, and the count"
    assert "(20 times like this)" in caplog.text


def test_depth_that_is_aligned_to_the_colour_is_depth(tmp_path: Path) -> None:
    aligned = "/camera/aligned_depth_to_color/image_raw"
    messages = robots_messages(aligned)
    colour = colour_message(np.full((24, 32, 3), 90, np.uint8), 0.0, "xtion")
    messages.insert(1, ("/camera/color/image_raw", IMAGE, 0.0, colour))
    topics = choose_topics(open_bag(mcap(tmp_path / "one", messages)), TopicNames())
    assert (topics.depth, topics.colour) == (aligned, "/camera/color/image_raw")
    plain = [
        one for one in robots_messages("/camera/depth/image_rect_raw") if one[1] != CAMERA_INFO
    ]
    topics = choose_topics(
        open_bag(mcap(tmp_path / "both", sorted([*messages, *plain], key=lambda one: one[2]))),
        TopicNames(),
    )
    assert (topics.depth, topics.colour) == (
        "/camera/depth/image_rect_raw",
        "/camera/color/image_raw",
    )


def test_a_depth_scale_holds_for_the_images_of_a_bag(tmp_path: Path) -> None:
    path = mcap(tmp_path, robots_messages())
    plain, scaled = (
        list(open_recording(path, settings=BagSettings(depth_scale=scale)))
        for scale in (None, 2.5e-4)
    )
    for one, other in zip(plain, scaled, strict=True):
        np.testing.assert_allclose(other.depth, one.depth / 4, rtol=1e-5)
    assert isinstance(open_recording(path), BagRecording)
