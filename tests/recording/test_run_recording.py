"""A replay gives the frames of the recorded run."""

from __future__ import annotations

import resource
import subprocess
import sys
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bag_world import CAMERA, frame, frames, recorded, same, without_odometry
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rosbags.highlevel import AnyReader

from circumspect.classification import Prediction
from circumspect.errors import InputError, OutputError
from circumspect.geometry import PlanarPose
from circumspect.localization import CeilingImage, LensCamera
from circumspect.recording import BagRecording, RunRecorder, open_bag, open_recording
from circumspect.recording.mcap_bag import McapBag
from circumspect.sensing import RgbdFrame

PREDICTION = Prediction.from_probabilities(["bed", "chair", "sofa"], np.array([0.2, 0.7, 0.1]))
EXTENT = np.array([[0.0, 1.0, 0.0], [0.5, 1.5, 0.9]])


def test_a_replay_gives_the_recorded_frames(tmp_path: Path) -> None:
    originals = [frame(number, colour=number % 2 == 0) for number in range(5)]
    originals[2] = without_odometry(originals[2])
    originals[3] = replace(originals[3], depth=originals[3].depth / 3)  # no whole millimetres
    handed_on = recorded(tmp_path / "run.mcap", originals)
    played = list(open_recording(tmp_path / "run.mcap"))
    assert len(played) == 5
    for passed, one, original in zip(handed_on, played, originals, strict=True):
        same(passed, one)
        np.testing.assert_array_equal(passed.depth, original.depth)
        if passed.odometry is not None and original.odometry is not None:
            assert passed.odometry.T_odom_base.xy == pytest.approx(original.odometry.T_odom_base.xy)


def test_late_and_repeated_frames_keep_their_order_and_odometry(tmp_path: Path) -> None:
    originals = [frame(n) for n in (0, 1, 3, 2, 4)]
    originals.append(replace(frame(9), stamp=originals[-1].stamp))
    handed_on = recorded(tmp_path / "run.mcap", originals)
    for passed, one in zip(handed_on, open_recording(tmp_path / "run.mcap"), strict=True):
        same(passed, one)


def test_a_negative_stamp_is_skipped_and_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    recorder = RunRecorder(tmp_path / "run.mcap", {})
    early = RgbdFrame(frame(1).depth, CAMERA, -1.0)
    assert recorder.frame(early) is early
    recorder.frame(frame(2))
    recorder.close()
    assert "missing from the recording" in caplog.text
    assert len(list(open_recording(tmp_path / "run.mcap"))) == 1


def test_rosbags_reads_a_recording(tmp_path: Path) -> None:
    recorder = RunRecorder(tmp_path / "run.mcap", {"config": "{}"})
    for one in frames(3):
        recorder.frame(one)
        recorder.answer(one.stamp, PREDICTION, EXTENT, PlanarPose(0.1, 0.2, 0.3))
    image = CeilingImage("ceiling_1", 0.25, np.full((24, 32), 9, np.uint8))
    recorder.ceiling_image(image, LensCamera(CAMERA, (0.1, 0.0, 0.0, 0.0, -0.2)))
    recorder.close()
    with AnyReader([tmp_path / "run.mcap"]) as reader:
        counts = {name: topic.msgcount for name, topic in reader.topics.items()}
        assert counts == {
            "/camera/depth/camera_info": 3, "/camera/depth/image_raw": 3, "/odom": 3, "/tf": 6,
            "/tf_static": 1, "/circumspect/detections": 3, "/ceiling_1/image_raw": 1,
            "/ceiling_1/camera_info": 1,
        }  # fmt: skip
        wanted = [c for c in reader.connections if c.topic == "/circumspect/detections"]
        connection, time, data = list(reader.messages(connections=wanted))[-1]
        assert time == 200_000_000
        (detection,) = reader.deserialize(data, connection.msgtype).detections
        scores = [(r.hypothesis.class_id, r.hypothesis.score) for r in detection.results]
        assert scores == [("chair", 0.7), ("bed", 0.2), ("sofa", 0.1)]
        assert detection.header.frame_id == "map"
        assert (detection.bbox.size.x, detection.bbox.center.position.y) == (0.5, 1.25)
        latched = next(c for c in reader.connections if c.topic == "/tf_static")
        assert latched.ext.offered_qos_profiles[0].durability.name == "TRANSIENT_LOCAL"


def test_an_existing_recording_is_never_overwritten(tmp_path: Path) -> None:
    recorded(tmp_path / "run.mcap", frames(1))
    before = (tmp_path / "run.mcap").read_bytes()
    with pytest.raises(OutputError, match="never overwritten"):
        RunRecorder(tmp_path / "run.mcap", {})
    assert (tmp_path / "run.mcap").read_bytes() == before
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        RunRecorder(tmp_path / "file" / "run.mcap", {})


def test_a_full_disk_ends_the_recording_and_keeps_the_frames_before(tmp_path: Path) -> None:
    path, originals = tmp_path / "run.mcap", frames(30)
    size = recorded(tmp_path / "whole.mcap", originals) and (tmp_path / "whole.mcap").stat().st_size
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    recorder = RunRecorder(path, {})
    resource.setrlimit(resource.RLIMIT_FSIZE, (size // 2, limits[1]))
    try:
        for one in originals:
            np.testing.assert_array_equal(recorder.frame(one).depth, one.depth)
        recorder.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert isinstance(recorder.failure, OutputError)
    assert "earlier messages are kept" in str(recorder.failure)
    played = list(open_recording(path))
    assert 8 < len(played) < 20
    for one, original in zip(played, originals, strict=False):
        np.testing.assert_array_equal(one.depth, original.depth)
    bag = McapBag(path)
    list(bag.messages(bag.topics))
    assert bag.error == "truncated after a complete record"


KILLED = """
import os, sys, time, random, signal
from dataclasses import replace
sys.path.insert(0, sys.argv[2])
from bag_world import frame
from circumspect.recording import RunRecorder
from circumspect.recording.ros_types import typestore
import mcap.writer
typestore()  # once, not in each child
made, rng = [frame(number) for number in range(40)], random.Random(0)
for moment in range(50):
    receive, send = os.pipe()
    child = os.fork()
    if child == 0:
        recorder = RunRecorder(f"{sys.argv[1]}/{moment}.mcap", {})
        for number in range(100000):
            again = number // 40 * 40 * (made[1].stamp - made[0].stamp)
            recorder.frame(replace(made[number % 40], stamp=made[number % 40].stamp + again))
            os.write(send, b".")
    os.read(receive, 1)
    time.sleep(rng.uniform(0, 0.03))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(send)
    count = 1
    while more := os.read(receive, 65536):
        count += len(more)
    os.close(receive)
    print(count, flush=True)
"""


def test_a_killed_process_leaves_all_recorded_frames(tmp_path: Path) -> None:
    here = str(Path(__file__).parent)
    child = subprocess.run(
        [sys.executable, "-c", KILLED, str(tmp_path), here],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    counts = [int(line) for line in child.stdout.split()]
    assert len(counts) == 50
    assert len(set(counts)) > 3, "at different moments"
    for moment, count in enumerate(counts):
        played = open_recording(tmp_path / f"{moment}.mcap")
        found = sum(1 for _ in played)
        assert found in (count, count + 1), "the last may be written before it is counted"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("small") / "run.mcap"
    recorded(path, frames(4))
    return path


def read_or_refused(path: Path) -> list[RgbdFrame]:
    """The frames; none where the file is refused with an InputError."""
    try:
        return list(open_recording(path))
    except InputError:
        return []


@given(st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_a_truncated_file_gives_the_frames_before_the_cut(small: Path, data: st.DataObject) -> None:
    complete = small.read_bytes()
    cut = data.draw(st.integers(0, len(complete) - 1))
    path = small.with_name("cut.mcap")
    path.write_bytes(complete[:cut])
    played = read_or_refused(path)
    for one, original in zip(played, frames(4), strict=False):
        np.testing.assert_array_equal(one.depth, original.depth)
        assert one.stamp == pytest.approx(original.stamp)


@given(st.lists(st.tuples(st.integers(0, 2**20), st.integers(0, 255)), min_size=1, max_size=8))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_overwritten_bytes_raise_no_other_error_than_input_error(
    small: Path, changes: list
) -> None:
    broken = bytearray(small.read_bytes())
    for place, value in changes:
        broken[place % len(broken)] = value
    path = small.with_name("broken.mcap")
    path.write_bytes(broken)
    read_or_refused(path)


@pytest.mark.parametrize("content", [b"", b"no recording", b"\x89MCAP0\r\n"])
def test_files_that_are_no_recordings_are_refused(tmp_path: Path, content: bytes) -> None:
    for name in ("x.mcap", "x.bag", "x.db3"):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=name):
            open_recording(tmp_path / name)
    with pytest.raises(InputError, match="can not be read"):
        open_recording(tmp_path / "missing.mcap")


def test_memory_does_not_grow_with_the_recording(tmp_path: Path) -> None:
    recorder = RunRecorder(tmp_path / "run.mcap", {})
    for number in range(120):
        recorder.frame(frame(number))
    recorder.close()
    recording = open_recording(tmp_path / "run.mcap")
    next(iter(recording))
    peaks = []
    for count in (20, 120):
        tracemalloc.start()
        for number, _ in enumerate(recording):
            if number == count:
                break
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0] + 200_000


def test_topic_times_are_known_with_and_without_an_index(tmp_path: Path) -> None:
    recorded(tmp_path / "run.mcap", frames(5))
    complete = (tmp_path / "run.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(complete[:-30])
    for name in ("run.mcap", "cut.mcap"):
        topic = open_bag(tmp_path / name).topics["/odom"]
        assert (topic.count, topic.first, topic.last) == (5, 0, 400_000_000)


def test_every_nth_frame(tmp_path: Path) -> None:
    recorded(tmp_path / "run.mcap", frames(7))
    recording = open_recording(tmp_path / "run.mcap", every=3)
    assert isinstance(recording, BagRecording)
    assert len(recording) == 3
    assert [one.stamp for one in recording] == pytest.approx([0.0, 0.3, 0.6])
    with pytest.raises(InputError, match="every 0"):
        open_recording(tmp_path / "run.mcap", every=0)


def test_a_folder_with_one_mcap_file_is_a_bag(tmp_path: Path) -> None:
    recorded(tmp_path / "run.mcap", frames(2))
    bag = open_bag(tmp_path)
    assert bag.kind == "MCAP"
    assert bag.topics["/odom"].count == 2
    assert len(list(open_recording(tmp_path))) == 2


@pytest.mark.parametrize(
    ("note", "error"), [("0.0", 0.0), ("1.7e-4", 1.7e-4), ("nan", None), ("-1", None), ("x", None)]
)
def test_the_systematic_error_of_the_camera_is_read_from_a_note(
    note: str, error: float | None, tmp_path: Path
) -> None:
    recorder = RunRecorder(tmp_path / "run.mcap", {"systematic_disparity": note})
    recorder.frame(frame(0))
    recorder.close()
    recording = open_recording(tmp_path / "run.mcap")
    assert isinstance(recording, BagRecording)
    assert recording.systematic_disparity == error
