"""Untrusted recordings: bombs, paths that lead elsewhere, data bases that compute."""

from __future__ import annotations

import bz2
import shutil
import sqlite3
import struct
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from little_memory import little_memory
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.recording.bag_safety import MAX_MESSAGE_BYTES, require_bounded_messages
from circumspect.recording.bounded_decompression import MAX_UNPACKED_BYTES, decompressed
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


@pytest.fixture(scope="module")
def bombs() -> dict[str, bytes]:
    return {name: pack(bytes(ZEROS)) for name, pack in PACKERS.items()}


@pytest.mark.parametrize("packing", PACKERS)
def test_unpacked_size_is_bounded(packing, bombs):
    data = np.random.default_rng(0).bytes(5000) * 3
    assert decompressed(PACKERS[packing](data), packing, len(data)) == data
    with little_memory(), pytest.raises(InputError, match="more than 1000 bytes"):
        decompressed(bombs[packing], packing, 1000)
    with pytest.raises(InputError, match=str(MAX_UNPACKED_BYTES)):
        decompressed(bombs[packing], packing, MAX_UNPACKED_BYTES + 1)


@pytest.mark.parametrize("packing", ["lz4", "bz2"])
def test_packed_data_that_end_early(packing):
    packed = PACKERS[packing](np.random.default_rng(0).bytes(5000))
    with pytest.raises(InputError, match="too early"):
        decompressed(packed[: len(packed) // 2], packing, 5000)


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
    assert bag.error is None
    assert str(bag.damage).startswith("1 damaged part")
    path.write_bytes(whole[:8] + chunk_record(bombs[packing], packing, claimed))
    with little_memory(), pytest.raises(InputError, match="contains no messages"):
        open_bag(path)


def test_a_chunk_of_a_million_empty_messages_is_skipped(tmp_path):
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
    assert bag.error is None
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
    monkeypatch.setattr("circumspect.recording.mcap_bag.MAX_TOPICS", 20)
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
    path = mcap_file(tmp_path / "large.mcap", bytes(MAX_MESSAGE_BYTES + 1))
    bag = open_bag(path)
    with little_memory(3 * MAX_MESSAGE_BYTES):
        assert list(bag.messages({"/odom"})) == []
    assert bag.undecoded["/odom", "nav_msgs/msg/Odometry"] == 1


def test_names_of_frames_are_bounded():
    tree = TransformTree()
    for names in (("map", "x" * 10_000), ("x" * 10_000, "map")):
        msg = transforms_message([transform_message(RigidTransform.identity(), 0.0, *names)])
        with pytest.raises(InputError, match="more than 1024 characters"):
            tree.add(msg)
    assert not tree.frames


def test_records_of_huge_length_are_refused(tmp_path):
    path = tmp_path / "long.mcap"
    path.write_bytes(b"\x89MCAP0\r\n\x01" + struct.pack("<Q", 2**60) + bytes(50))
    with little_memory(), pytest.raises(InputError, match="contains no messages"):
        open_bag(path)


@pytest.mark.parametrize("packing", ["lz4", "bz2"])
def test_chunks_of_ros_1_are_bounded(packing, tmp_path, monkeypatch):
    store = get_typestore(Stores.ROS1_NOETIC)
    path = tmp_path / "bomb.bag"
    writer = Writer1(path)
    writer.set_compression(Writer1.CompressionFormat[packing.upper()])
    with writer:
        connection = writer.add_connection("/a", "std_msgs/msg/String", typestore=store)
        msg = store.types["std_msgs/msg/String"](data="x" * (1 << 20))
        writer.write(connection, 1, store.serialize_ros1(msg, "std_msgs/msg/String"))
    assert len(list(open_bag(path).messages({"/a"}))) == 1
    monkeypatch.setattr("circumspect.recording.bounded_decompression.MAX_UNPACKED_BYTES", 1 << 19)
    monkeypatch.setattr(decompressed, "__defaults__", (1 << 19,))
    bag = open_bag(path)
    assert list(bag.messages({"/a"})) == []
    assert bag.error == "truncated: decompresses to more than 524288 bytes"


@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_packed_bags_of_ros_2_are_bounded(mode, tmp_path, monkeypatch):
    store, kind = typestore(), "std_msgs/msg/String"
    writer = Writer2(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/a", kind, typestore=store)
        msg = store.types[kind](data="x" * (1 << 20))
        writer.write(connection, 1, bytes(store.serialize_cdr(msg, kind)))
    assert len(list(open_bag(tmp_path / "bag").messages({"/a"}))) == 1
    for name in ("MAX_UNPACKED_BYTES", "ALWAYS_ALLOWED_BYTES"):
        monkeypatch.setattr(f"circumspect.recording.bounded_decompression.{name}", 1 << 19)
    monkeypatch.setattr(decompressed, "__defaults__", (1 << 19,))
    if mode is CompressionMode.FILE:
        with pytest.raises(InputError, match="too large when decompressed"):
            open_bag(tmp_path / "bag")
    else:
        bag = open_bag(tmp_path / "bag")
        assert list(bag.messages({"/a"})) == []
        assert "decompresses to more than" in str(bag.error)


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
    with pytest.raises(InputError, match="database with computed rows"):
        open_bag(path)
    shouted = path.rename(tmp_path / "A.DB3")
    with pytest.raises(InputError, match="database with computed rows"):
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


def test_an_index_of_exponential_yaml_aliases_is_refused(tmp_path):
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
