"""MCAP files with flipped bits: only damaged chunks are lost."""

from __future__ import annotations

from pathlib import Path

import pytest
from bag_world import frame
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import SeekingReader
from mcap.writer import CompressionType, Writer

from circumspect.errors import InputError
from circumspect.recording import RunRecorder, open_recording
from circumspect.recording.mcap_bag import McapBag

COUNT = 12


def recorded(path: Path) -> bytes:
    recorder = RunRecorder(path, {})
    for number in range(COUNT):
        recorder.frame(frame(number))
    recorder.close()
    return path.read_bytes()


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return recorded(tmp_path_factory.mktemp("sound") / "run.mcap")


@pytest.fixture(scope="module")
def chunks(sound: bytes, tmp_path_factory: pytest.TempPathFactory) -> list[tuple[int, int]]:
    """Begin and length of each chunk, with opcode and length."""
    path = tmp_path_factory.mktemp("index") / "run.mcap"
    path.write_bytes(sound)
    with path.open("rb") as stream:
        summary = SeekingReader(stream).get_summary()
    assert summary is not None
    return [(one.chunk_start_offset, one.chunk_length) for one in summary.chunk_indexes]


def flipped(content: bytes, at: int, bit: int) -> bytes:
    changed = bytearray(content)
    changed[at] ^= 1 << bit
    return bytes(changed)


def played(path: Path) -> int:
    try:
        return len(list(open_recording(path)))
    except InputError:
        return 0


@given(place=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
@settings(max_examples=40)
def test_a_flipped_bit_loses_its_chunk(
    sound: bytes, tmp_path_factory: pytest.TempPathFactory, place: float, bit: int
) -> None:
    path = tmp_path_factory.mktemp("flipped") / "run.mcap"
    at = 8 + int(place * (len(sound) - 8))
    path.write_bytes(flipped(sound, at, bit))
    assert played(path) >= COUNT - 1


@pytest.mark.parametrize("bit", range(8))
@pytest.mark.parametrize("byte", range(9))
@pytest.mark.parametrize("with_index", [True, False])
def test_a_damaged_opcode_or_length_loses_its_chunk(
    sound: bytes,
    chunks: list[tuple[int, int]],
    tmp_path: Path,
    byte: int,
    bit: int,
    with_index: bool,
) -> None:
    begin, _ = chunks[len(chunks) // 2]
    content = flipped(sound, begin + byte, bit)
    path = tmp_path / "run.mcap"
    path.write_bytes(content if with_index else content[: chunks[-1][0]])
    bag = McapBag(path)
    count = sum(1 for _ in bag.messages(bag.topics))
    path.write_bytes(sound if with_index else sound[: chunks[-1][0]])
    whole = McapBag(path)
    assert count >= sum(1 for _ in whole.messages(whole.topics)) - 8
    assert whole.damage is None
    if byte or bit < 7:  # An opcode of 128 or more belongs to another program.
        assert str(bag.damage).startswith("1 damaged part")


def test_topics_that_only_a_damaged_chunk_describes_are_known_from_the_index(
    sound: bytes, chunks: list[tuple[int, int]], tmp_path: Path
) -> None:
    begin, length = chunks[0]
    path = tmp_path / "run.mcap"
    path.write_bytes(flipped(sound, begin + length // 2, 3))
    assert played(path) >= COUNT - 1


@pytest.mark.parametrize("bit", range(8))
def test_a_damaged_index_loses_nothing(sound: bytes, tmp_path: Path, bit: int) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(flipped(sound, sound.rindex(b"\3\0\0\0cdr") + 6, bit))
    assert played(path) == COUNT


def test_damaged_chunks_are_reported(
    sound: bytes, chunks: list[tuple[int, int]], tmp_path: Path
) -> None:
    path, content = tmp_path / "run.mcap", sound
    for begin, length in chunks[2:9:3]:
        content = flipped(content, begin + length - 5, 0)
    path.write_bytes(content)
    recording = open_recording(path)
    assert len(list(recording)) >= COUNT - 3
    size = sum(length for _, length in chunks[2:9:3])
    reason = f"3 damaged parts, {size} of {len(sound)} bytes"
    assert recording.skipped["damaged parts"] == reason


@given(place=st.floats(0.1, 0.9), bit=st.integers(0, 7))
@settings(max_examples=20)
def test_files_without_chunks_lose_little(
    tmp_path_factory: pytest.TempPathFactory, place: float, bit: int
) -> None:
    path = tmp_path_factory.mktemp("plain") / "run.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE, use_chunking=False)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"")
        channel = writer.register_channel("/a", "cdr", schema)
        for number in range(50):
            data = b"\0\1\0\0" + (101).to_bytes(4, "little") + b"x" * 100 + b"\0"
            writer.add_message(channel, number, data, number)
        writer.finish()
    content = path.read_bytes()
    first = content.index(b"x" * 100)
    at = first + int(place * 50 * 140)
    path.write_bytes(flipped(content, at, bit))
    bag = McapBag(path)
    times = [message.log_time for message in bag.messages({"/a"})]
    assert len(times) >= 48
    assert bag.error is None
