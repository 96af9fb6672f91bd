"""Bags whose middle is damaged: the rest is read."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st
from rosbags.rosbag1 import Writer as Writer1
from rosbags.typesys import Stores, get_typestore

from circumspect.recording.open_recording import open_bag
from circumspect.recording.ros_bag import RESOLUTION_NS, ReadableSegments

SECOND = 10**9
STRING = "std_msgs/msg/String"


@given(
    times=st.lists(st.integers(0, 100 * SECOND), min_size=1, unique=True).map(sorted),
    damage=st.lists(st.tuples(st.integers(0, 100), st.integers(0, 100)), max_size=3),
)
def test_intact_segments_are_read(times: list[int], damage: list[tuple[int, int]]) -> None:
    broken = [(begin * SECOND, (begin + length) * SECOND) for begin, length in damage]

    def is_broken(time: int) -> bool:
        return any(begin <= time < end for begin, end in broken)

    def read(start: int) -> Iterator[tuple[int, int]]:
        for time in times:
            if time >= start:
                if is_broken(time):
                    raise ValueError("malformed")
                yield time, time

    found = ReadableSegments(read, times[0], times[-1] + 1)
    read_times = [time for time, _ in found]
    assert read_times == sorted(set(read_times))
    assert not any(map(is_broken, read_times))
    intact = [time for time in times if not is_broken(time)]
    assert set(read_times) <= set(intact)
    # A search with growing steps may skip short intact segments between damaged ones.
    if len(broken) <= 1 and broken:
        begin, end = broken[0]
        for time in set(intact) - set(read_times):
            assert begin <= time < end + 2 * RESOLUTION_NS
    if not broken:
        assert read_times == times


def ros1_in_chunks(path: Path) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    unopened = Writer1(path)
    unopened.set_compression(Writer1.CompressionFormat.LZ4)
    with unopened as writer:
        writer.chunk_threshold = 20_000
        topic = writer.add_connection("/a", STRING, typestore=store)
        for number in range(100):
            text = store.types[STRING](
                data="".join(chr(97 + (n * number) % 26) for n in range(2000))
            )
            writer.write(topic, number * SECOND // 10 + 1, store.serialize_ros1(text, STRING))
    return path


def test_a_damaged_chunk_of_ros_1_loses_only_itself(tmp_path: Path) -> None:
    path = ros1_in_chunks(tmp_path / "robot.bag")
    content = bytearray(path.read_bytes())
    whole = [one.log_time for one in open_bag(path).messages({"/a"})]
    begin = content.index(b"compression=lz4", len(content) // 2)
    content[begin + 60 : begin + 64] = b"\xff" * 4
    path.write_bytes(content)
    bag = open_bag(path)
    found = [one.log_time for one in bag.messages({"/a"})]
    assert len(whole) == 100
    assert set(found) < set(whole)
    assert len(found) > 75
    assert found[-1] == whole[-1]
    assert str(bag.damage).startswith("1 damaged part, ")
    assert bag.error is None
