"""Bags as other programs write them: ROS 1, db3, MCAP of rosbags; what is read of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_world import CAMERA, MOUNT, frame
from foreign_bags import COUNT, FORMATS, Write, db3_file, driven, mcap, robots_messages, ros1
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.recording import is_bag, open_bag, open_recording
from circumspect.recording.pose_messages import transform_message, transform_of
from circumspect.recording.ros_types import IMAGE


@pytest.mark.parametrize("write", FORMATS)
def test_a_foreign_bag_is_read(tmp_path: Path, write: Write) -> None:
    recording = open_recording(write(tmp_path, robots_messages()))
    found = list(recording)
    assert len(found) == len(recording) == COUNT
    assert not recording.skipped
    expected = transform_of(*parts(MOUNT))
    for number, one in enumerate(found):
        np.testing.assert_array_equal(one.depth, frame(number).depth)
        assert one.camera == CAMERA
        assert one.stamp == pytest.approx(0.1 * number)
        assert one.T_base_camera is not None
        np.testing.assert_allclose(one.T_base_camera.as_matrix(), expected.as_matrix(), atol=1e-12)
        assert one.odometry is not None
        true = driven(one.stamp)
        assert one.odometry.T_odom_base.xy == pytest.approx(true.xy, abs=1e-9)
        assert one.odometry.T_odom_base.yaw == pytest.approx(true.yaw, abs=1e-9)
        assert one.T_map_camera is None


@pytest.mark.parametrize("write", [db3_file, mcap, ros1])
def test_a_suffix_may_be_in_capitals(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path, robots_messages())
    shouted = tmp_path / "shouted" / f"GOOD{path.suffix.upper()}"
    shouted.parent.mkdir()
    path.rename(shouted)
    assert is_bag(shouted)
    assert open_bag(shouted).kind == {".BAG": "ROS 1 bag", ".DB3": "ROS 2 bag"}.get(
        shouted.suffix, "MCAP"
    )
    assert len(list(open_recording(shouted))) == COUNT
    assert is_bag(shouted.parent) == (write is not ros1), "a folder of one file of a bag of ROS 2"


def parts(T: RigidTransform) -> tuple[Any, Any]:
    messages = transform_message(T, 0.0, "a", "b").transform
    return messages.translation, messages.rotation


def test_a_slash_before_frames_is_ros_1(tmp_path: Path) -> None:
    messages = robots_messages()
    for topic, _, _, message in messages:
        if topic == "/odom":
            message.child_frame_id = "/base_footprint"
    assert next(iter(open_recording(ros1(tmp_path, messages)))).T_base_camera is not None


def test_colour_of_the_same_size_is_added_to_frames(tmp_path: Path) -> None:
    from circumspect.recording.image_messages import colour_message

    colour = np.random.default_rng(0).integers(0, 256, (24, 32, 3)).astype(np.uint8)
    messages = robots_messages()
    for number in range(COUNT):
        stamp = 0.1 * number
        message = colour_message(colour[: 24 - (number == 2)], stamp + 0.005, "xtion")
        messages.append(("/camera/color/image_raw", IMAGE, stamp + 1e-4, message))
    path = mcap(tmp_path, sorted(messages, key=lambda one: one[2]))
    found = [one.colour is not None for one in open_recording(path)]
    assert found == [True, True, False, True, True, True]


def test_unreadable_frames_are_skipped_with_the_reason(tmp_path: Path) -> None:
    messages = robots_messages()
    images = [message for topic, _, _, message in messages if topic.endswith("image_raw")]
    images[1].encoding = "bayer_rggb16"
    images[2].height = 23
    images[3].data = images[3].data[:100]
    recording = open_recording(mcap(tmp_path, messages))
    assert len(list(recording)) == COUNT - 3
    reasons = " ".join(recording.skipped.values())
    for word in ("bayer_rggb16", "32 x 23", "100 bytes"):
        assert word in reasons


def test_a_bag_of_unknown_encodings_is_refused(tmp_path: Path) -> None:
    messages = robots_messages()
    for topic, _, _, message in messages:
        if topic.endswith("image_raw"):
            message.encoding = "bayer_rggb16"
    with pytest.raises(InputError, match=r"no frame can be read: .*bayer_rggb16"):
        list(open_recording(mcap(tmp_path, messages)))


def test_invalid_messages_are_reported_and_skipped(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    messages = robots_messages()
    for topic, _, time, message in messages:
        if topic == "/odom" and 0.1 < time < 0.2:
            message.pose.pose.position.x = np.nan
    assert len(list(open_recording(mcap(tmp_path, messages)))) == COUNT
    assert "message on /odom skipped" in caplog.text
