"""Recordings of strangers: bombs, paths that lead elsewhere, data bases that compute."""

from __future__ import annotations

import bz2
import io
import os
import resource
import shutil
import sqlite3
import struct
import tracemalloc
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from PIL import Image
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.localization.image_folder import read_grey
from circumspect.localization.json_file import read_document
from circumspect.recording import open_recording
from circumspect.recording.bag_safety import LARGEST_MESSAGE, require_bounded_messages
from circumspect.recording.bounded_unpacking import LARGEST, unpacked
from circumspect.recording.image_files import read_colour, read_depth
from circumspect.recording.matrix_file import read_pose
from circumspect.recording.open_recording import open_bag
from circumspect.recording.pose_messages import transform_message, transforms_message
from circumspect.recording.ros_types import typestore
from circumspect.recording.transform_tree import TransformTree

ZEROS = 64 << 20
"""Bytes that the small bombs here unpack to."""
PACKERS = {
    "zstd": lambda data: zstandard.ZstdCompressor().compress(data),
    "lz4": lz4.frame.compress,
    "bz2": bz2.compress,
}


@contextmanager
def little_memory(most: int = 24 << 20) -> Iterator[None]:
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()


@pytest.fixture(scope="module")
def bombs() -> dict[str, bytes]:
    return {name: pack(bytes(ZEROS)) for name, pack in PACKERS.items()}


@pytest.mark.parametrize("packing", PACKERS)
def test_nothing_unpacks_to_more_than_was_agreed_on(packing, bombs):
    data = np.random.default_rng(0).bytes(5000) * 3
    assert unpacked(PACKERS[packing](data), packing, len(data)) == data
    with little_memory(), pytest.raises(InputError, match="more than 1000 bytes"):
        unpacked(bombs[packing], packing, 1000)
    with pytest.raises(InputError, match=str(LARGEST)):
        unpacked(bombs[packing], packing, LARGEST + 1)


@pytest.mark.parametrize("packing", ["lz4", "bz2"])
def test_packed_data_that_end_early(packing):
    packed = PACKERS[packing](np.random.default_rng(0).bytes(5000))
    with pytest.raises(InputError, match="too early"):
        unpacked(packed[: len(packed) // 2], packing, 5000)


def mcap_file(path: Path, data: bytes = bytes(100)) -> Path:
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.NONE, use_chunking=False)
        writer.start()
        schema = writer.register_schema("nav_msgs/msg/Odometry", "ros2msg", b"")
        channel = writer.register_channel("/odom", "cdr", schema)
        writer.add_message(channel, 1, data, 1)
        writer.finish()
    return path


def chunk_record(packed: bytes, packing: str, claimed: int) -> bytes:
    name = packing.encode()
    body = struct.pack("<QQQII", 0, 1, claimed, 0, len(name)) + name
    body += struct.pack("<Q", len(packed)) + packed
    return b"\x06" + struct.pack("<Q", len(body)) + body


@pytest.mark.parametrize("packing", ["zstd", "lz4"])
@pytest.mark.parametrize("claimed", [100, 2**62])
def test_a_chunk_that_is_a_bomb_is_left_out(packing, claimed, bombs, tmp_path):
    path = mcap_file(tmp_path / "bomb.mcap")
    whole = path.read_bytes()
    end = whole.index(b"\x0f" + struct.pack("<Q", 4))  # The end of the data.
    path.write_bytes(whole[:end] + chunk_record(bombs[packing], packing, claimed) + whole[end:])
    bag = open_bag(path)
    with little_memory():
        assert list(bag.messages({"/odom"})) == []
    assert bag.fault is None
    assert str(bag.damage).startswith("1 damaged part")
    path.write_bytes(whole[:8] + chunk_record(bombs[packing], packing, claimed))
    with little_memory(), pytest.raises(InputError, match="holds no messages"):
        open_bag(path)


def test_a_chunk_of_a_million_messages_of_nothing_is_left_out(tmp_path):
    path = mcap_file(tmp_path / "many.mcap")
    whole = path.read_bytes()
    plain = 10**6 * (b"\x05" + struct.pack("<QHIQQ", 22, 1, 0, 1, 1))
    end = whole.index(b"\x0f" + struct.pack("<Q", 4))
    packed = PACKERS["zstd"](plain)
    path.write_bytes(whole[:end] + chunk_record(packed, "zstd", len(plain)))
    assert path.stat().st_size < 10_000
    with little_memory(80 << 20):
        bag = open_bag(path)
    assert "1 damaged part" in str(bag.damage)
    assert bag.topics["/odom"].count < 10_000


def test_a_large_chunk_of_a_sound_recording_is_read(tmp_path):
    path, count = mcap_file(tmp_path / "large.mcap"), 100_000
    whole = path.read_bytes()
    plain = b"".join(
        b"\x05" + struct.pack("<QHIQQ", 122, 1, n, 10**7 * n, 10**7 * n) + bytes(100)
        for n in range(count)
    )
    end = whole.index(b"\x0f" + struct.pack("<Q", 4))
    packed = chunk_record(PACKERS["zstd"](plain), "zstd", len(plain))
    path.write_bytes(whole[:end] + packed + whole[end : end + 13])
    bag = open_bag(path)
    assert bag.fault is None
    assert bag.topics["/odom"].count == count + 1


def text(value: bytes) -> bytes:
    return struct.pack("<I", len(value)) + value


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


LONG = b"x" * (8 << 20)


@pytest.mark.parametrize(
    "described",
    [
        lambda n: record(3, struct.pack("<H", n) + text(LONG) + text(b"ros2msg") + text(b"")),
        lambda n: record(3, struct.pack("<H", n) + text(b"a") + text(LONG) + text(b"")),
        lambda n: record(4, struct.pack("<HH", n, 1) + text(LONG) + text(b"cdr") + text(b"")),
        lambda n: record(4, struct.pack("<HH", n, 1) + text(b"/a") + text(LONG) + text(b"")),
        lambda n: record(
            4, struct.pack("<HH", n, 1) + text(b"/a") + text(b"cdr") + text(text(b"k") + text(LONG))
        ),
    ],
    ids=["type", "encoding of a type", "topic", "encoding of a topic", "notes of a topic"],
)
def test_names_in_packed_chunks_are_bounded(described, tmp_path):
    """A few kilobytes for each name: twelve of them took two gigabytes."""
    path = mcap_file(tmp_path / "names.mcap")
    whole = path.read_bytes()
    end = whole.index(b"\x0f" + struct.pack("<Q", 4))
    chunks = b""
    for number in range(2, 10):
        message = record(5, struct.pack("<HIQQ", number, 0, 1, 1))
        plain = described(number) + message
        chunks += chunk_record(PACKERS["zstd"](plain), "zstd", len(plain))
    path.write_bytes(whole[:end] + chunks)
    with little_memory(40 << 20):
        bag = open_bag(path)
    assert set(bag.topics) == {"/odom"}
    assert str(bag.damage).startswith("1 damaged part, ")


def test_more_topics_than_any_robot_has(tmp_path, monkeypatch):
    monkeypatch.setattr("circumspect.recording.mcap_bag.MOST_TOPICS", 20)
    path = mcap_file(tmp_path / "topics.mcap")
    whole = path.read_bytes()
    end = whole.index(b"\x0f" + struct.pack("<Q", 4))
    plain = b"".join(
        record(4, struct.pack("<HH", 7, 1) + text(b"/%d" % n) + text(b"cdr") + text(b""))
        + record(5, struct.pack("<HIQQ", 7, 0, 1, 1))
        for n in range(30)
    )
    path.write_bytes(whole[:end] + chunk_record(plain, "", len(plain)))
    with pytest.raises(InputError, match="more than 20 topics"):
        open_bag(path)


def test_messages_that_are_larger_than_any_of_their_type_are_not_decoded(tmp_path):
    path = mcap_file(tmp_path / "large.mcap", bytes(LARGEST_MESSAGE + 1))
    bag = open_bag(path)
    with little_memory(3 * LARGEST_MESSAGE):
        assert list(bag.messages({"/odom"})) == []
    assert bag.undecoded["/odom", "nav_msgs/msg/Odometry"] == 1


def test_names_of_frames_are_bounded():
    tree = TransformTree()
    for names in (("map", "x" * 10_000), ("x" * 10_000, "map")):
        told = transforms_message([transform_message(RigidTransform.identity(), 0.0, *names)])
        with pytest.raises(InputError, match="more than 1024 characters"):
            tree.heard(told)
    assert not tree.frames


def test_records_that_claim_to_be_endless(tmp_path):
    path = tmp_path / "long.mcap"
    path.write_bytes(b"\x89MCAP0\r\n\x01" + struct.pack("<Q", 2**60) + bytes(50))
    with little_memory(), pytest.raises(InputError, match="holds no messages"):
        open_bag(path)


@pytest.mark.parametrize("packing", ["lz4", "bz2"])
def test_chunks_of_ros_1_are_bounded(packing, tmp_path, monkeypatch):
    store = get_typestore(Stores.ROS1_NOETIC)
    path = tmp_path / "bomb.bag"
    writer = Writer1(path)
    writer.set_compression(Writer1.CompressionFormat[packing.upper()])
    with writer:
        connection = writer.add_connection("/a", "std_msgs/msg/String", typestore=store)
        told = store.types["std_msgs/msg/String"](data="x" * (1 << 20))
        writer.write(connection, 1, store.serialize_ros1(told, "std_msgs/msg/String"))
    assert len(list(open_bag(path).messages({"/a"}))) == 1
    monkeypatch.setattr("circumspect.recording.bounded_unpacking.LARGEST", 1 << 19)
    monkeypatch.setattr(unpacked, "__defaults__", (1 << 19,))
    bag = open_bag(path)
    assert list(bag.messages({"/a"})) == []
    assert bag.fault == "broken off: unpacks to more than 524288 bytes"


@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_packed_bags_of_ros_2_are_bounded(mode, tmp_path, monkeypatch):
    store, kind = typestore(), "std_msgs/msg/String"
    writer = Writer2(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/a", kind, typestore=store)
        told = store.types[kind](data="x" * (1 << 20))
        writer.write(connection, 1, bytes(store.serialize_cdr(told, kind)))
    assert len(list(open_bag(tmp_path / "bag").messages({"/a"}))) == 1
    for name in ("LARGEST", "HARMLESS_FILE"):
        monkeypatch.setattr(f"circumspect.recording.bounded_unpacking.{name}", 1 << 19)
    monkeypatch.setattr(unpacked, "__defaults__", (1 << 19,))
    if mode is CompressionMode.FILE:
        with pytest.raises(InputError, match="far more than it may"):
            open_bag(tmp_path / "bag")
    else:
        bag = open_bag(tmp_path / "bag")
        assert list(bag.messages({"/a"})) == []
        assert "unpacks to more than" in str(bag.fault)


SELF_FEEDING = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x FROM c"


@pytest.mark.parametrize(
    "statements",
    [
        [
            "CREATE TABLE messages(id)",
            "CREATE TABLE topics(id)",
            f"CREATE VIEW v AS {SELF_FEEDING}",
        ],
        [
            "CREATE TABLE topics(id)",
            "CREATE TABLE messages(id, data GENERATED ALWAYS AS (zeroblob(1000000000)))",
        ],
        ["CREATE TABLE topics(id)", "CREATE VIRTUAL TABLE messages USING fts5(data)"],
    ],
)
def test_data_bases_that_compute_are_refused(statements, tmp_path):
    path = tmp_path / "a#b?mode=rwc.db3"
    base = sqlite3.connect(tmp_path / "plain.db3")
    for statement in statements:
        try:
            base.execute(statement)
        except sqlite3.OperationalError as error:
            pytest.skip(f"this SQLite can not make the file: {error}")
    base.commit()
    base.close()
    shutil.move(tmp_path / "plain.db3", path)
    with pytest.raises(InputError, match="computes its rows"):
        open_bag(path)
    shouted = path.rename(tmp_path / "A.DB3")
    with pytest.raises(InputError, match="computes its rows"):
        open_bag(shouted)


def test_a_data_base_whose_words_are_no_text(tmp_path):
    path = tmp_path / "a.db3"
    base = sqlite3.connect(path)
    base.execute("CREATE TABLE messages(id)")
    base.execute("CREATE TABLE topics(name)")
    base.commit()
    base.close()
    path.write_bytes(path.read_bytes().replace(b"topics(name)", b"topics(\xff\xfe__)"))
    with pytest.raises(InputError, match="can not be read"):
        open_bag(path)


@pytest.mark.parametrize(
    "definition",
    [
        "Nothing[] many\n" + "=" * 80 + "\nMSG: evil_msgs/Nothing\n",
        "Outer[] many\n" + "=" * 80 + "\nMSG: evil_msgs/Outer\nNothing one\n"
        + "=" * 80 + "\nMSG: evil_msgs/Nothing\n",
        "uint8[2000000000] many\n",
    ],
)  # fmt: skip
def test_messages_that_could_hold_billions_of_nothing(definition):
    types = get_types_from_msg(definition, "evil_msgs/msg/Bomb")
    with pytest.raises(InputError, match=r"evil_msgs/msg/Bomb\.many"):
        require_bounded_messages(types)


def test_messages_of_ros_are_bounded():
    for store in (Stores.ROS1_NOETIC, Stores.ROS2_JAZZY):
        require_bounded_messages(get_typestore(store).fielddefs)


def test_an_index_that_laughs_a_billion_times(tmp_path):
    lines = ["a0: &a0 [ha, ha, ha, ha, ha, ha, ha, ha, ha, ha]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 10)]
    (tmp_path / "metadata.yaml").write_text(
        "\n".join(lines)
        + "\nrosbag2_bagfile_information:\n  version: 5\n  relative_file_paths: []\n"
        "  storage_identifier: sqlite3\n  compression_mode: file\n  compression_format: *a9\n"
    )
    with little_memory(), pytest.raises(InputError, match="references"):
        open_bag(tmp_path)


def test_an_index_that_is_huge_or_nested_without_end(tmp_path):
    index = tmp_path / "metadata.yaml"
    index.write_text("a: " + "[" * 20_000)
    with pytest.raises(InputError, match="can not be read"):
        open_bag(tmp_path)
    with index.open("wb") as stream:
        stream.truncate(2**40)
    with pytest.raises(InputError, match="at most"):
        open_bag(tmp_path)


@pytest.mark.parametrize("name", ["/etc/passwd", "../secret.png", "depth/../../secret.png"])
@pytest.mark.parametrize("lists", ["depth.txt", "rgb.txt"])
def test_lists_of_images_stay_in_their_folder(name, lists, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "depth.txt").write_text("1.0 depth.png\n")
    (folder / lists).write_text(f"1.0 {name}\n")
    with pytest.raises(InputError, match="outside of the folder"):
        open_recording(folder)


def test_pipes_are_not_waited_for(tmp_path):
    for name in ("a.png", "a.mcap", "a.db3", "a.bag"):
        os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match="not a regular file"):
        read_depth(tmp_path / "a.png")
    assert read_colour(tmp_path / "a.png", (4, 4)) is None
    with pytest.raises(InputError, match="not a regular file"):
        read_grey(tmp_path / "a.png")
    os.mkfifo(tmp_path / "depth.txt")
    with pytest.raises(InputError, match="not a regular file"):
        open_recording(tmp_path)
    os.mkfifo(tmp_path / "pose.txt")
    with pytest.raises(InputError, match="not a regular file"):
        read_pose(tmp_path / "pose.txt")
    os.mkfifo(tmp_path / "space.json")
    with (
        pytest.raises(InputError, match="not a regular file"),
        read_document(tmp_path / "space.json"),
    ):
        pass
    for suffix in ("mcap", "db3", "bag"):
        with pytest.raises(InputError, match="not a regular file"):
            open_bag(tmp_path / f"a.{suffix}")


def png_bomb(width: int, height: int, bits: int) -> bytes:
    """A picture of one colour; only its first rows are there."""

    def part(name: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        )

    head = struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)
    rows = zlib.compress(bytes(1 << 20))
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", rows) + part(b"IEND", b"")


@pytest.mark.parametrize("size", [(13_000, 13_000), (2**31 - 1, 1), (100_000, 100_000)])
def test_pictures_of_nothing_are_not_unpacked(size, tmp_path):
    path = tmp_path / "a.png"
    for bits, read in ((16, read_depth), (8, read_grey)):
        path.write_bytes(png_bomb(*size, bits))
        with little_memory(), pytest.raises(InputError, match=r"a\.png"):
            read(path)
    with little_memory():
        assert read_colour(path, (640, 480)) is None


def test_chunks_of_pictures_that_announce_gigabytes(tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(np.arange(48, dtype=np.uint16).reshape(6, 8)).save(path)
    whole = path.read_bytes()
    at = whole.index(b"IDAT") - 4
    path.write_bytes(whole[:at] + b"\xff\xff\xff\xff" + whole[at + 4 :])
    limits = resource.getrlimit(resource.RLIMIT_AS)
    used = 4096 * int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 30), limits[1]))
    try:
        with suppress(InputError):
            assert read_depth(path).shape == (6, 8)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)


def test_formats_that_other_programs_would_run_are_not_opened(tmp_path):
    buffer = io.BytesIO()
    Image.new("RGB", (4, 4)).save(buffer, "EPS")
    for name in ("frame-000000.color.jpg", "a.png"):
        (tmp_path / name).write_bytes(buffer.getvalue())
    assert read_colour(tmp_path / "frame-000000.color.jpg", (4, 4)) is None
    with pytest.raises(InputError, match="can not be read"):
        read_grey(tmp_path / "a.png")


def test_stamps_that_are_no_text(tmp_path):
    from circumspect.localization.image_folder import ImageFolder

    (tmp_path / "north").mkdir()
    Image.new("L", (4, 4)).save(tmp_path / "north" / "1.png")
    (tmp_path / "north" / "stamps.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"stamps\.txt: can not be read"):
        ImageFolder(tmp_path)


def test_names_of_strangers_command_no_terminal(tmp_path, capsys):
    from circumspect.cli.main import main

    path = tmp_path / "names.mcap"
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.NONE, use_chunking=False)
        writer.start()
        for name in ("/\x1b[2J\x1b]0;depth\x07", "/[/red]depth", "/[link=http://x]depth"):
            schema = writer.register_schema("sensor_msgs/msg/Image", "ros2msg", b"")
            writer.add_message(writer.register_channel(name, "cdr", schema), 1, b"", 1)
        writer.finish()
    assert main(["record", "info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert "/[/red]depth" in out
    assert main(["replay", str(path), "--out", str(tmp_path / "run")]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "\x1b" not in err
