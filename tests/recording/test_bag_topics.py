"""The topics of a bag: found, chosen by name, missing, or holding something else."""

from __future__ import annotations

from pathlib import Path

import pytest
from foreign_bags import COUNT, TimedMessage, Write, mcap, robots_messages, ros1, without
from mcap.writer import Writer

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording import (
    BagRecording,
    BagSettings,
    TopicNames,
    open_bag,
    open_recording,
)
from circumspect.recording.ros_types import IMAGE, ODOMETRY, typestore


def test_a_bag_without_camera_info_needs_intrinsics(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/camera/depth/camera_info"))
    with pytest.raises(InputError, match=r"no CameraInfo .* --intrinsics"):
        open_recording(path)
    other = PinholeCamera(32, 24, 28.0, 28.0, 16.0, 12.0)
    found = list(open_recording(path, settings=BagSettings(camera=other)))
    assert {one.camera for one in found} == {other}


def test_without_odometry_frames_have_none(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/odom"))
    assert all(one.odometry is None for one in open_recording(path))
    named = BagSettings(TopicNames(odometry="/wheels"))
    with pytest.raises(InputError, match=r"contains no /wheels \(--odometry-topic\)"):
        open_recording(path, settings=named)


def test_odometry_can_be_left_out(tmp_path: Path) -> None:
    path = mcap(tmp_path, robots_messages())
    found = open_recording(path, settings=BagSettings(TopicNames(odometry="")))
    assert all(one.odometry is None for one in found)


@pytest.mark.parametrize(
    ("names", "reason"),
    [
        ({"info": "/odom"}, "/odom (--info-topic) holds nav_msgs/msg/Odometry, not "
         "sensor_msgs/msg/CameraInfo; /camera/depth/camera_info has such a type"),
        ({"depth": "/odom", "info": "/camera/depth/camera_info"},
         "/odom (--depth-topic) holds nav_msgs/msg/Odometry, not sensor_msgs/msg/Image or "
         "sensor_msgs/msg/CompressedImage; /camera/depth/image_raw has such a type"),
        ({"odometry": "/camera/depth/image_raw"}, "/camera/depth/image_raw (--odometry-topic) "
         "holds sensor_msgs/msg/Image, not nav_msgs/msg/Odometry; /odom has such a type"),
        ({"odometry": "/tf_static"}, "/tf_static (--odometry-topic) holds tf2_msgs/msg/TFMessage, "
         "not nav_msgs/msg/Odometry; /odom has such a type"),
        ({"colour": "/odom"}, "/odom (--colour-topic) holds nav_msgs/msg/Odometry, not "
         "sensor_msgs/msg/Image; no topic has such a type"),
    ],
    ids=["info", "depth", "odometry", "transforms", "colour"],
)  # fmt: skip
@pytest.mark.parametrize("write", [mcap, ros1])
def test_a_topic_of_another_type_is_refused_with_those_that_fit(
    tmp_path: Path, write: Write, names: dict[str, str], reason: str
) -> None:
    path = write(tmp_path, robots_messages())
    with pytest.raises(InputError) as error:
        open_recording(path, settings=BagSettings(TopicNames(**names)))
    assert str(error.value) == f"{path}: {reason}"


def test_several_depth_topics_need_a_choice(tmp_path: Path) -> None:
    messages = [
        *robots_messages("/left/depth/image_raw"),
        *robots_messages("/right/depth/image_raw"),
    ]
    path = mcap(tmp_path, sorted(messages, key=lambda one: one[2]))
    with pytest.raises(InputError, match=r"several topics may hold the depth: /left.*/right"):
        open_recording(path)
    choose_topics = BagSettings(TopicNames(depth="/right/depth/image_raw"))
    assert len(list(open_recording(path, settings=choose_topics))) == COUNT


@pytest.mark.parametrize("rectified", ["image_rect_raw", "image_rect"])
def test_rectified_images_are_preferred_to_raw_ones(tmp_path: Path, rectified: str) -> None:
    messages = [
        *robots_messages("/camera/depth/image_raw"),
        *[one for one in robots_messages(f"/camera/depth/{rectified}") if one[1] == IMAGE],
    ]
    recording = open_recording(mcap(tmp_path, sorted(messages, key=lambda one: one[2])))
    assert isinstance(recording, BagRecording)
    assert recording.topics.depth == f"/camera/depth/{rectified}"


def with_empty(
    path: Path, messages: list[TimedMessage], *empty: tuple[str, str], counted: bool = True
) -> Path:
    """A bag of messages and of topics without messages."""
    store = typestore()
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channels = {}
        for topic, kind in dict.fromkeys([*empty, *(one[:2] for one in messages)]):
            schema = writer.register_schema(kind, "ros2msg", b"")
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        for topic, kind, time, message in messages:
            data = bytes(store.serialize_cdr(message, kind))
            writer.add_message(channels[topic], round(1e9 * time), data, round(1e9 * time))
        if not counted:
            vars(writer)["_Writer__statistics"].channel_message_counts.clear()
        writer.finish()
    return path


@pytest.mark.parametrize("counted", [True, False])
def test_topics_without_messages_are_ignored(tmp_path: Path, counted: bool) -> None:
    empty = [("/other/depth/image_raw", IMAGE), ("/other/odom", ODOMETRY), ("/rgb/image", IMAGE)]
    path = with_empty(tmp_path / "a.mcap", robots_messages(), *empty, counted=counted)
    recording = open_recording(path)
    assert isinstance(recording, BagRecording)
    assert not {topic for topic, _ in empty} & set(recording.bag.topics)
    assert recording.topics.odometry == "/odom"
    assert len(recording) == len(list(recording)) == COUNT


def test_an_empty_odometry_topic_does_not_hide_another(tmp_path: Path) -> None:
    messages = [("/wheels" if one[0] == "/odom" else one[0], *one[1:]) for one in robots_messages()]
    path = with_empty(tmp_path / "a.mcap", messages, ("/odom", ODOMETRY))
    assert all(one.odometry is not None for one in open_recording(path))


def test_a_bag_without_messages_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="contains no messages"):
        open_bag(with_empty(tmp_path / "a.mcap", [], ("/depth/image", IMAGE)))


def test_a_bag_without_depth_topics_is_refused_with_its_topics(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/camera/depth/image_raw"))
    with pytest.raises(InputError, match=r"no topic holds depth images; topics: .*/odom"):
        open_recording(path)
