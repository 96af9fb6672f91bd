"""Bags as other programs write them: ROS 1, db3, MCAP of rosbags; and broken ones."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_world import CAMERA, MOUNT, assert_same_pose, frame
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.recording import (
    BagRecording,
    BagSettings,
    GivenPoses,
    TopicNames,
    is_bag,
    open_bag,
    open_recording,
)
from circumspect.recording.bag import BagMessage
from circumspect.recording.frame_assembly import AssemblySettings, ClockError, FrameAssembly
from circumspect.recording.image_messages import camera_info, depth_message
from circumspect.recording.pose_messages import (
    odometry_message,
    transform_message,
    transform_of,
    transforms_message,
)
from circumspect.recording.ros_types import CAMERA_INFO, IMAGE, ODOMETRY, TRANSFORMS, typestore
from circumspect.recording.topic_choice import ChosenTopics
from circumspect.sensing import Odometry

COUNT = 6
Told = tuple[str, str, float, Any]
"""Topic, type, time [s], message."""


def driven(stamp: float) -> PlanarPose:
    return PlanarPose(0.2 * stamp, 0.1 * stamp, 0.5 * stamp)


def robots_messages(depth: str = "/camera/depth/image_raw") -> list[Told]:
    """A robot whose wheels tell at other times than its camera, the mount in two links."""
    half = RigidTransform.from_translation([0.0, 0.0, 0.5])
    links = [
        transform_message(half, 0.0, "base_footprint", "mast"),
        transform_message(half.inv() * MOUNT, 0.0, "mast", "xtion"),
    ]
    told: list[Told] = [("/tf_static", TRANSFORMS, 0.0, transforms_message(links))]
    space = depth.rsplit("/", 1)[0]
    for number in range(COUNT):
        stamp = 0.1 * number
        told.append(
            (f"{space}/camera_info", CAMERA_INFO, stamp, camera_info(CAMERA, stamp, "xtion"))
        )
        told.append((depth, IMAGE, stamp, depth_message(frame(number).depth, stamp, "xtion")))
    for number in range(20):
        stamp = 0.04 * number
        odometry = Odometry(stamp, driven(stamp), stamp * np.eye(3))
        told.append(
            ("/odom", ODOMETRY, stamp, odometry_message(odometry, "odom", "base_footprint"))
        )
    return sorted(told, key=lambda one: one[2])


def written2(path: Path, told: list[Told], plugin: StoragePlugin) -> Path:
    store = typestore()
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        topics: dict[str, Any] = {}
        for topic, kind, time, message in told:
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(topics[topic], round(time * 1e9), store.serialize_cdr(message, kind))
    return path


def written1(path: Path, told: list[Told]) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))
    with Writer1(path) as writer:
        topics: dict[str, Any] = {}
        for topic, kind, time, message in told:
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            data = store.serialize_ros1(as_ros1(store, message, kind), kind)
            writer.write(topics[topic], round(time * 1e9) + 1, data)
    return path


def as_ros1(store: Any, message: Any, kind: str) -> Any:
    """The same message in ROS 1's types: a header has a count, CameraInfo's fields are capitals."""
    fields = {}
    for name, (node, detail) in store.fielddefs[kind][1]:
        value = getattr(message, name if hasattr(message, name) else name.lower(), 0)
        if node.name == "NAME" and kind != "std_msgs/msg/Header":
            value = as_ros1(store, value, detail)
        elif node.name in ("ARRAY", "SEQUENCE") and detail[0][0].name == "NAME":
            value = [as_ros1(store, one, detail[0][1]) for one in value]
        fields[name] = value
    return store.types[kind](**fields)


def db3(folder: Path, told: list[Told]) -> Path:
    return written2(folder / "bag", told, StoragePlugin.SQLITE3)


def db3_file(folder: Path, told: list[Told]) -> Path:
    return next(db3(folder, told).glob("*.db3"))


def mcap(folder: Path, told: list[Told]) -> Path:
    return next(written2(folder / "bag", told, StoragePlugin.MCAP).glob("*.mcap"))


def ros1(folder: Path, told: list[Told]) -> Path:
    return written1(folder / "robot.bag", told)


Write = Callable[[Path, list[Told]], Path]
FORMATS = [db3, db3_file, mcap, ros1]


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
    assert is_bag(shouted.parent) == (write is mcap), "a folder of one MCAP file"


def parts(T: RigidTransform) -> tuple[Any, Any]:
    told = transform_message(T, 0.0, "a", "b").transform
    return told.translation, told.rotation


def test_a_slash_before_frames_is_ros_1(tmp_path: Path) -> None:
    told = robots_messages()
    for topic, _, _, message in told:
        if topic == "/odom":
            message.child_frame_id = "/base_footprint"
    assert next(iter(open_recording(ros1(tmp_path, told)))).T_base_camera is not None


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


def without(told: list[Told], topic: str) -> list[Told]:
    return [one for one in told if one[0] != topic]


def test_without_camera_info_intrinsics_are_asked_for(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/camera/depth/camera_info"))
    with pytest.raises(InputError, match=r"no CameraInfo .* --intrinsics"):
        open_recording(path)
    other = PinholeCamera(32, 24, 28.0, 28.0, 16.0, 12.0)
    found = list(open_recording(path, settings=BagSettings(camera=other)))
    assert {one.camera for one in found} == {other}


def test_a_camera_info_that_never_comes_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("circumspect.recording.frame_assembly.WITHOUT_CAMERA", 3)
    told = robots_messages()
    last = next(one for one in reversed(told) if one[1] == CAMERA_INFO)
    late = [one for one in told if one[1] != CAMERA_INFO or one is last]
    with pytest.raises(InputError, match="no CameraInfo comes"):
        list(open_recording(mcap(tmp_path, late)))


def test_without_transforms_there_is_no_mount_unless_it_is_given(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/tf_static"))
    assert all(one.T_base_camera is None for one in open_recording(path))
    given = open_recording(path, settings=BagSettings(T_base_camera=MOUNT))
    assert_same_pose(next(iter(given)).T_base_camera, MOUNT)


def test_without_odometry_frames_have_none(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/odom"))
    assert all(one.odometry is None for one in open_recording(path))
    named = BagSettings(TopicNames(odometry="/wheels"))
    with pytest.raises(InputError, match=r"holds no /wheels \(--odometry-topic\)"):
        open_recording(path, settings=named)


def test_odometry_can_be_left_out(tmp_path: Path) -> None:
    path = mcap(tmp_path, robots_messages())
    found = open_recording(path, settings=BagSettings(TopicNames(odometry="")))
    assert all(one.odometry is None for one in found)


@pytest.mark.parametrize(
    ("names", "told"),
    [
        ({"info": "/odom"}, "/odom (--info-topic) holds nav_msgs/msg/Odometry, not "
         "sensor_msgs/msg/CameraInfo; /camera/depth/camera_info would fit"),
        ({"depth": "/odom", "info": "/camera/depth/camera_info"},
         "/odom (--depth-topic) holds nav_msgs/msg/Odometry, not sensor_msgs/msg/Image or "
         "sensor_msgs/msg/CompressedImage; /camera/depth/image_raw would fit"),
        ({"odometry": "/camera/depth/image_raw"}, "/camera/depth/image_raw (--odometry-topic) "
         "holds sensor_msgs/msg/Image, not nav_msgs/msg/Odometry; /odom would fit"),
        ({"odometry": "/tf_static"}, "/tf_static (--odometry-topic) holds tf2_msgs/msg/TFMessage, "
         "not nav_msgs/msg/Odometry; /odom would fit"),
        ({"colour": "/odom"}, "/odom (--colour-topic) holds nav_msgs/msg/Odometry, not "
         "sensor_msgs/msg/Image; no topic would fit"),
    ],
    ids=["info", "depth", "odometry", "transforms", "colour"],
)  # fmt: skip
@pytest.mark.parametrize("write", [mcap, ros1])
def test_a_topic_that_holds_something_else_is_told_with_those_that_fit(
    tmp_path: Path, write: Write, names: dict[str, str], told: str
) -> None:
    path = write(tmp_path, robots_messages())
    with pytest.raises(InputError) as error:
        open_recording(path, settings=BagSettings(TopicNames(**names)))
    assert str(error.value) == f"{path}: {told}"


def test_several_likely_topics_are_asked_for(tmp_path: Path) -> None:
    told = [*robots_messages("/left/depth/image_raw"), *robots_messages("/right/depth/image_raw")]
    path = mcap(tmp_path, sorted(told, key=lambda one: one[2]))
    with pytest.raises(InputError, match=r"several topics may hold the depth: /left.*/right"):
        open_recording(path)
    chosen = BagSettings(TopicNames(depth="/right/depth/image_raw"))
    assert len(list(open_recording(path, settings=chosen))) == COUNT


def test_without_depth_topics_those_there_are_named(tmp_path: Path) -> None:
    path = mcap(tmp_path, without(robots_messages(), "/camera/depth/image_raw"))
    with pytest.raises(InputError, match=r"no topic holds depth images; there are .*/odom"):
        open_recording(path)


def test_frames_that_can_not_be_read_are_left_out_with_the_reason(tmp_path: Path) -> None:
    told = robots_messages()
    images = [message for topic, _, _, message in told if topic.endswith("image_raw")]
    images[1].encoding = "bayer_rggb16"
    images[2].height = 23
    images[3].data = images[3].data[:100]
    recording = open_recording(mcap(tmp_path, told))
    assert len(list(recording)) == COUNT - 3
    reasons = " ".join(recording.skipped.values())
    for word in ("bayer_rggb16", "32 x 23", "100 bytes"):
        assert word in reasons


def test_nothing_but_unknown_encodings_is_an_error(tmp_path: Path) -> None:
    told = robots_messages()
    for topic, _, _, message in told:
        if topic.endswith("image_raw"):
            message.encoding = "bayer_rggb16"
    with pytest.raises(InputError, match=r"no frame can be read: .*bayer_rggb16"):
        list(open_recording(mcap(tmp_path, told)))


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


def test_messages_that_make_no_sense_are_told_and_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    told = robots_messages()
    for topic, _, time, message in told:
        if topic == "/odom" and 0.1 < time < 0.2:
            message.pose.pose.position.x = np.nan
    assert len(list(open_recording(mcap(tmp_path, told)))) == COUNT
    assert "a message on /odom left out" in caplog.text


@pytest.mark.parametrize("write", FORMATS)
def test_a_bag_that_is_cut_is_a_known_fault_or_a_shorter_one(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path, robots_messages())
    file = path if path.is_file() else next(path.glob("*.db3"))
    whole = file.read_bytes()
    for share in (0.02, 0.3, 0.6, 0.9, 0.999):
        file.write_bytes(whole[: int(share * len(whole))])
        assert len(read_or_refused(path)) <= COUNT


@pytest.fixture(scope="module", params=FORMATS)
def sound(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return request.param(tmp_path_factory.mktemp("sound"), robots_messages())


HEAD = st.integers(0, 5000)
CHANGES = st.lists(
    st.tuples(st.one_of(HEAD, st.integers(0, 2**20)), st.binary(min_size=1, max_size=8)),
    min_size=1, max_size=6,
)  # fmt: skip


@given(changes=CHANGES, index=st.booleans())
@settings(max_examples=25)
def test_a_bag_that_was_tampered_with_is_a_known_fault_at_most(
    sound: Path, changes: list[tuple[int, bytes]], index: bool
) -> None:
    """Its file, or the index of its folder, with a few bytes of somebody else's."""
    copy = sound.parent / f"tampered{sound.suffix}"
    if sound.is_dir():
        shutil.copytree(sound, copy, dirs_exist_ok=True)
    else:
        shutil.copy(sound, copy)
    file = copy
    if sound.is_dir():
        file = copy / "metadata.yaml" if index else next(copy.glob("*.db3"))
    content = bytearray(file.read_bytes())
    for place, values in changes:
        at = place % len(content)
        content[at : at + len(values)] = values
    file.write_bytes(content)
    read_or_refused(copy)


def read_or_refused(path: Path) -> list[Any]:
    try:
        return list(open_recording(path))
    except InputError:
        return []


def test_an_index_of_a_missing_file_is_told(tmp_path: Path) -> None:
    folder = db3(tmp_path, robots_messages())
    next(folder.glob("*.db3")).unlink()
    with pytest.raises(InputError, match="can not be read"):
        open_recording(folder)


def test_colour_of_the_same_size_adorns_frames(tmp_path: Path) -> None:
    from circumspect.recording.image_messages import colour_message

    colour = np.random.default_rng(0).integers(0, 256, (24, 32, 3)).astype(np.uint8)
    told = robots_messages()
    for number in range(COUNT):
        stamp = 0.1 * number
        message = colour_message(colour[: 24 - (number == 2)], stamp + 0.005, "xtion")
        told.append(("/camera/color/image_raw", IMAGE, stamp + 1e-4, message))
    path = mcap(tmp_path, sorted(told, key=lambda one: one[2]))
    found = [one.colour is not None for one in open_recording(path)]
    assert found == [True, True, False, True, True, True]
