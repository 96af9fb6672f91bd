"""Bags in other forms: packed messages, ROS 1 and Foxglove in MCAP, folders without an index."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_world import CAMERA, frame
from foreign_bags import COUNT, TimedMessage, as_ros1, db3, driven, mcap, robots_messages, ros1
from mcap.writer import Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from circumspect.errors import InputError
from circumspect.recording import is_bag, open_bag, open_recording
from circumspect.recording.ros_types import ros1_typestore, typestore


def are_the_robots(path: Path) -> None:
    """All frames of the robot come back."""
    recording = open_recording(path)
    found = list(recording)
    assert len(found) == COUNT
    assert not recording.skipped
    for number, one in enumerate(found):
        np.testing.assert_allclose(one.depth, frame(number).depth, rtol=1e-6)
        assert one.camera == CAMERA
        assert one.T_base_camera is not None
        assert one.odometry is not None
        assert one.odometry.T_odom_base.xy == pytest.approx(driven(one.stamp).xy, abs=1e-9)


def packed_one_by_one(folder: Path, plugin: StoragePlugin) -> Path:
    """As `ros2 bag record --compression-mode message` writes it."""
    store = typestore()
    writer = Writer2(folder, version=9, storage_plugin=plugin)
    writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
    with writer:
        topics: dict[str, Any] = {}
        for topic, kind, time, message in robots_messages():
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(topics[topic], round(time * 1e9), store.serialize_cdr(message, kind))
    return folder


@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_messages_that_are_packed_one_by_one_are_read(
    tmp_path: Path, plugin: StoragePlugin
) -> None:
    folder = packed_one_by_one(tmp_path / "bag", plugin)
    are_the_robots(folder)
    if plugin is StoragePlugin.MCAP:
        are_the_robots(next(folder.glob("*.mcap")))


def converted(path: Path, msg: list[TimedMessage]) -> Path:
    """As `mcap convert robot.bag robot.mcap` writes it: ROS 1's bytes and names."""
    store = ros1_typestore()
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros1", library="mcap")
        channels: dict[str, int] = {}
        for topic, kind, time, message in msg:
            if topic not in channels:
                definition, _ = store.generate_msgdef(kind, ros_version=1)
                schema = writer.register_schema(
                    kind.replace("/msg/", "/"), "ros1msg", definition.encode()
                )
                channels[topic] = writer.register_channel(topic, "ros1", schema)
            data = bytes(store.serialize_ros1(as_ros1(store, message, kind), kind))
            at = round(time * 1e9)
            writer.add_message(channels[topic], at, data, at)
        writer.finish()
    return path


def test_messages_of_ros_1_in_mcap_are_read(tmp_path: Path) -> None:
    path = converted(tmp_path / "robot.mcap", robots_messages())
    are_the_robots(path)
    assert open_bag(path).topics["/odom"].kind == "nav_msgs/msg/Odometry"


def foxglove(kind: str, message: Any) -> list[tuple[str, Any]]:
    """The same messages as Foxglove types."""
    from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
    from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
    from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
    from foxglove_schemas_protobuf.Odometry_pb2 import Odometry
    from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

    def stamped(msg: Any, header: Any, frame_id: str = "frame_id") -> Any:
        msg.timestamp.seconds, msg.timestamp.nanos = header.stamp.sec, header.stamp.nanosec
        setattr(msg, frame_id, header.frame_id)
        return msg

    def placed(msg: Any, place: Any, turn: Any, names: tuple[str, str]) -> None:
        for name in "xyz":
            setattr(getattr(msg, names[0]), name, getattr(place, name))
        for name in "xyzw":
            setattr(getattr(msg, names[1]), name, getattr(turn, name))

    if kind.endswith("TFMessage"):
        made = []
        for one in message.transforms:
            msg = stamped(FrameTransform(), one.header, "parent_frame_id")
            msg.child_frame_id = one.child_frame_id
            moved = one.transform
            placed(msg, moved.translation, moved.rotation, ("translation", "rotation"))
            made.append(msg)
        # One by one, and several at a time.
        return [
            ("FrameTransform", made[0]),
            ("FrameTransforms", FrameTransforms(transforms=made[1:])),
        ]
    if kind.endswith("CameraInfo"):
        msg = CameraCalibration(width=message.width, height=message.height)
        msg.K.extend(message.k)
        msg.P.extend(message.p)
        return [("CameraCalibration", stamped(msg, message.header))]
    if kind.endswith("Odometry"):
        msg = stamped(Odometry(body_frame_id=message.child_frame_id), message.header)
        pose = message.pose.pose
        placed(msg.pose, pose.position, pose.orientation, ("position", "orientation"))
        msg.pose_covariance.extend(message.pose.covariance)
        return [("Odometry", msg)]
    msg = RawImage(
        width=message.width, height=message.height, encoding=message.encoding, step=message.step,
        data=bytes(message.data),
    )  # fmt: skip
    return [("RawImage", stamped(msg, message.header))]


def foxgloves(path: Path, msg: list[TimedMessage]) -> Path:
    """As a program with Foxglove's SDK writes it."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(library="foxglove")
        channels: dict[tuple[str, str], int] = {}
        for topic, kind, time, message in msg:
            name = topic.replace("camera_info", "calibration")
            for schema, one in foxglove(kind, message):
                if (name, schema) not in channels:
                    number = writer.register_schema(f"foxglove.{schema}", "protobuf", b"")
                    channels[name, schema] = writer.register_channel(name, "protobuf", number)
                at = round(time * 1e9)
                writer.add_message(channels[name, schema], at, one.SerializeToString(), at)
        writer.finish()
    return path


def test_foxgloves_messages_are_read(tmp_path: Path) -> None:
    are_the_robots(foxgloves(tmp_path / "robot.mcap", robots_messages()))


def test_an_encoding_that_is_not_known_is_named_with_those_that_are(tmp_path: Path) -> None:
    path = tmp_path / "robot.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("foxglove.RawImage", "jsonschema", b"{}")
        writer.add_message(writer.register_channel("/depth", "json", schema), 0, b"{}", 0)
        writer.finish()
    with pytest.raises(
        InputError, match=r"/depth holds foxglove.RawImage as json; supported: .*cdr.*ros1"
    ):
        list(open_bag(path).messages({"/depth"}))


@pytest.mark.parametrize("write", [db3, mcap])
def test_a_folder_that_lost_its_index_is_read_if_it_holds_one_file(tmp_path: Path, write) -> None:
    write(tmp_path, robots_messages())
    (tmp_path / "bag" / "metadata.yaml").unlink()
    assert is_bag(tmp_path / "bag")
    are_the_robots(tmp_path / "bag")


@pytest.mark.parametrize(("write", "storage"), [(db3, "sqlite3"), (mcap, "mcap")])
def test_of_several_files_without_an_index_the_remedy_is_named(
    tmp_path: Path, write, storage: str
) -> None:
    write(tmp_path, robots_messages())
    folder = tmp_path / "bag"
    (folder / "metadata.yaml").unlink()
    (file,) = folder.iterdir()
    file.with_name(f"second{file.suffix}").write_bytes(file.read_bytes())
    with pytest.raises(InputError, match=rf"2 files .*ros2 bag reindex -s {storage} {folder}"):
        open_recording(folder)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("run.mcap.zst", "compressed MCAP file; decompress it with: zstd -d"),
        ("run_0.db3.zstd", "give the bag's folder with its metadata.yaml"),
        ("2024.bag.active", "not closed; repair it with: rosbag reindex"),
        ("scene0000_00.sens", "SensReader"),
    ],
)
def test_files_that_only_look_like_recordings_are_identified(
    tmp_path: Path, name: str, words: str
) -> None:
    path = tmp_path / name
    path.write_bytes(b"\x28\xb5\x2f\xfd whatever")
    with pytest.raises(InputError, match=words) as error:
        open_recording(path)
    assert str(path) in str(error.value)


def test_a_folder_of_a_packed_file_without_an_index_names_the_remedy(tmp_path: Path) -> None:
    path = ros1(tmp_path, robots_messages()).rename(tmp_path / "run.mcap.zst")
    with pytest.raises(InputError, match=r"run.mcap.zst: is a compressed MCAP file"):
        open_recording(path.parent)
