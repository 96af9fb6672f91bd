"""`scan --record`, `replay` of what it made, and `record info`."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from circumspect.cli.main import main
from circumspect.cli.opened_recording import left_out_lines
from circumspect.geometry import PinholeCamera, read_cloud
from circumspect.recording import RunRecorder
from circumspect.sensing import RgbdFrame

FLAGS = ["chair-3", "--start", "40", "--seed", "5", "--frames", "8", "--frame-interval", "2"]
WRITTEN = ("trajectory.txt", "model.ply", "grid.npz")


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("live")
    recording = ["--record", str(folder / "run.mcap")]
    assert main(["scan", *FLAGS, *recording, "--out", str(folder / "run"), "--json"]) == 0
    return folder


def played(live: Path, out: Path, *flags: str) -> dict:
    assert main(["replay", str(live / "run.mcap"), *flags, "--out", str(out), "--json"]) == 0
    return json.loads((out / "result.json").read_text())


def test_a_replay_gives_the_live_run_bit_for_bit(live: Path, tmp_path: Path) -> None:
    again = played(live, tmp_path / "again")
    before = json.loads((live / "run" / "result.json").read_text())
    for name in (
        "label",
        "probability",
        "probabilities",
        "frames",
        "outcomes",
        "coverage",
        "points",
    ):
        assert again[name] == before[name]
    for name in WRITTEN:
        assert (tmp_path / "again" / name).read_bytes() == (live / "run" / name).read_bytes()


def log(run: Path) -> list[dict]:
    """The log of each frame, without its processing time."""
    lines = (run / "log.jsonl").read_text().splitlines()
    return [{**json.loads(line), "milliseconds": None} for line in lines]


def test_a_replay_of_a_truncated_bag_is_the_run_so_far(live: Path, tmp_path: Path) -> None:
    content = (live / "run.mcap").read_bytes()
    (tmp_path / "run.mcap").write_bytes(content[: len(content) // 2])
    part = played(tmp_path, tmp_path / "part")
    assert 2 <= part["frames"] < 8
    assert log(tmp_path / "part") == log(live / "run")[: part["frames"]]


def test_a_box_and_given_poses(live: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    # The room has no known layout: take the box from the model of the live run.
    points = read_cloud(live / "run" / "model.ply").points_xyz
    low, high = points.min(axis=0) - 0.02, points.max(axis=0) + 0.02
    box = [f"{value:.3f}" for value in (*low, *high)]
    capsys.readouterr()
    result = played(live, tmp_path / "box", "--box", *box, "--poses", "hidden")
    errors = json.loads(capsys.readouterr().out)
    assert result["frames"] == 8
    assert errors["ate_rmse_m"] < 0.05, "the poses that the live run recorded, one frame late"


def test_record_info(live: Path, capsys: pytest.CaptureFixture) -> None:
    assert main(["record", "info", str(live / "run.mcap"), "--json"]) == 0
    info = json.loads(capsys.readouterr().out)
    assert info["kind"] == "MCAP"
    assert info["broken"] is None
    assert info["topics"]["/camera/depth/image_raw"]["count"] == 8
    assert info["topics"]["/circumspect/detections"]["count"] == 9  # one of them at the end
    assert info["seconds"] == pytest.approx(14.0)
    assert info["notes"]["config"]["object"] == "chair-3"
    assert info["replay"]["odometry"] == "/odom"
    assert main(["record", "info", str(live / "run.mcap")]) == 0
    text = capsys.readouterr().out
    assert "nav_msgs/Odometry" in text
    _, *table, replayed = text.splitlines()
    assert max(map(len, table)) <= 80
    assert replayed.startswith("Replayed are /camera/depth/image_raw (depth), ")


def copy_bag(
    source: Path,
    copy: Path,
    *,
    topic: Callable[[str], str] = str,
    delay_ns: Callable[[str], int] = lambda _: 0,
) -> None:
    """Write the same messages, with other topics and in another order."""
    with source.open("rb") as old, copy.open("wb") as new:
        writer = Writer(new)
        writer.start()
        messages = [
            (message.log_time + delay_ns(channel.topic), schema, channel, message)
            for schema, channel, message in make_reader(old).iter_messages()
        ]
        for time, schema, channel, message in sorted(messages, key=lambda one: one[0]):
            kind = writer.register_schema(schema.name, schema.encoding, schema.data)
            name = topic(channel.topic)
            number = writer.register_channel(name, channel.message_encoding, kind)
            writer.add_message(number, time, message.data, time)
        writer.finish()


def test_a_mount_that_is_recorded_late_holds_for_all_images(
    live: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    """As in most bags of real robots, whose drivers start one after the other."""
    copy_bag(
        live / "run.mcap", tmp_path / "run.mcap",
        delay_ns=lambda topic: 5_000_000_000 * (topic == "/tf_static"),
    )  # fmt: skip
    capsys.readouterr()
    assert played(tmp_path, tmp_path / "late")["frames"] == 8
    assert "left out" not in capsys.readouterr().err
    shown = ["--from", str(tmp_path / "run.mcap"), "--label", "chair", "--name", "mine"]
    assert main(["gather", "--out", str(tmp_path / "set"), *shown]) == 0


@pytest.fixture
def blind(live: Path, tmp_path: Path) -> Path:
    """The bag of the live run, with another topic name for its CameraInfo."""
    path = tmp_path / "blind.mcap"
    copy_bag(
        live / "run.mcap", path,
        topic=lambda topic: topic.replace("/camera/depth/camera_info", "/camera/other/camera_info"),
    )  # fmt: skip
    return path


def test_record_info_gives_the_reason_why_a_replay_fails(
    blind: Path, capsys: pytest.CaptureFixture
) -> None:
    assert main(["replay", str(blind)]) == 2
    refused = capsys.readouterr().err
    assert main(["record", "info", str(blind), "--json"]) == 0
    reason = json.loads(capsys.readouterr().out)["replay"]
    assert f"circumspect: {reason}\n" == refused
    assert "--info-topic" in reason
    assert main(["record", "info", str(blind)]) == 0
    text = capsys.readouterr().out
    assert "A replay needs help" in text
    assert "Replayed are" not in text


def test_skipped_images_of_one_reason_are_one_line() -> None:
    skipped = {f"frame {n} at {n}.0 s": f"an image of {n} bytes" for n in range(40)}
    lines = left_out_lines({**skipped, "the end": "truncated"})
    assert lines == [
        "frame 0 at 0.0 s and 39 more left out: an image of 0 bytes",
        "the end left out: truncated",
    ]


@pytest.mark.parametrize(
    ("scale", "words"),
    [("1000", "for 1000 units a metre give 0.001"), ("0", "0: give metres a unit")],
)
def test_an_invalid_depth_scale_is_refused(
    live: Path, capsys: pytest.CaptureFixture, scale: str, words: str
) -> None:
    assert main(["replay", str(live / "run.mcap"), "--depth-scale", scale]) == 2
    assert words in capsys.readouterr().err


def test_a_depth_scale_scales_the_model(live: Path, tmp_path: Path) -> None:
    """The room is twice as large: the floor no longer lies where the mount places it."""
    flags = ["--depth-scale", "0.002", "--out", str(tmp_path), "--json"]
    assert main(["replay", str(live / "run.mcap"), *flags]) == 1
    assert json.loads((tmp_path / "config.json").read_text())["depth_scale"] == 0.002


LONG = "/warehouse_robot_17/front_left_camera"


@pytest.fixture
def crowded(live: Path, tmp_path: Path) -> Path:
    """The live run's bag with all of its topics twice, once below a long name."""
    path = tmp_path / "crowded.mcap"
    with (live / "run.mcap").open("rb") as old, path.open("wb") as new:
        writer = Writer(new)
        writer.start()
        for schema, channel, message in make_reader(old).iter_messages():
            kind = writer.register_schema(schema.name, schema.encoding, schema.data)
            for name in (channel.topic, LONG + channel.topic):
                topic = writer.register_channel(name, channel.message_encoding, kind)
                writer.add_message(topic, message.log_time, message.data, message.publish_time)
        writer.finish()
    return path


def test_record_info_in_a_pipe_is_not_cut(crowded: Path, capsys: pytest.CaptureFixture) -> None:
    """Users copy topics from it, and programs search its lines."""
    assert main(["record", "info", str(crowded)]) == 0
    lines = capsys.readouterr().out.splitlines()
    (depth,) = [line for line in lines if line.startswith(f"{LONG}/camera/depth/image_raw ")]
    assert depth.split()[1:3] == ["sensor_msgs/Image", "8"]
    assert lines[-1].startswith("A replay needs help: ")
    assert "--depth-topic" in lines[-1]
    assert "…" not in "".join(lines)


def test_record_info_on_a_terminal_keeps_to_its_width(
    crowded: Path, capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["record", "info", str(crowded)]) == 0
    text = re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out)
    lines = text.splitlines()[1:]
    assert max(map(len, lines)) <= 80
    assert "…" not in text
    first = "".join(line.split()[0] for line in lines if line.strip() and line[0] != " ")
    assert f"{LONG}/camera/depth/image_raw" in first


def test_an_unknown_map_frame_is_refused_with_the_known_ones(
    live: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    flags = ["--poses", "given", "--map-frame", "nowhere", "--out", str(tmp_path / "run")]
    assert main(["replay", str(live / "run.mcap"), *flags]) == 2
    error = capsys.readouterr().err
    assert "'nowhere'" in error
    assert "base_link" in error
    assert "--map-frame" in error
    assert error.count("\n") == 1


def test_notes_that_are_no_json_are_shown_as_text(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    recorder = RunRecorder(tmp_path / "odd.mcap", {"config": "{no json"})
    recorder.frame(RgbdFrame(np.ones((2, 3)), PinholeCamera(3, 2, 1.0, 1.0, 1.0, 0.5), 1.0))
    recorder.close()
    assert main(["record", "info", str(tmp_path / "odd.mcap"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["notes"]["config"] == "{no json"


@pytest.mark.parametrize(
    ("flags", "reason"),
    [
        (["replay", "nowhere.mcap"], "nowhere.mcap: can not be read"),
        (["replay", "run.mcap", "--depth-topic", "/x"], "contains no /x"),
        (
            ["replay", "run.mcap", "--info-topic", "/odom"],
            "/camera/depth/camera_info has such a type",
        ),
        (["replay", "run.mcap", "--mount", "0", "0", "1", "0", "90"], "a tilt within 90"),
        (["replay", "run.mcap", "--intrinsics", "0", "1", "2", "3"], "focal lengths"),
        (["replay", "run.mcap", "--size", "320", "240"], "--intrinsics describe: give both"),
        (["record", "info", "nowhere"], "is no bag"),
        (
            ["replay", "run", "--intrinsics", "3", "3", "1", "1", "--map-frame", "world"],
            "run: is no bag; only bags take --map-frame, --intrinsics; a folder describes its "
            "camera in camera-intrinsics.txt",
        ),
        (["replay", "run", "--depth-topic", "/x"], "only bags take --depth-topic"),
        (["scan", "chair", "--record", "run.mcap"], "never overwritten"),
        (["scan", "chair", "--record", "run.bag"], "run.bag: recordings are MCAP files"),
    ],
)
def test_errors_are_one_line(
    live: Path, flags: list[str], reason: str, capsys: pytest.CaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(live)
    assert main(flags) == 2
    error = capsys.readouterr().err
    assert reason in error
    assert len(error.splitlines()) == 1


def test_a_folder_of_frames_needs_a_box(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    from PIL import Image

    Image.fromarray(np.full((4, 4), 1000, np.uint16)).save(tmp_path / "frame-000000.depth.png")
    np.savetxt(tmp_path / "frame-000000.pose.txt", np.eye(4))
    assert main(["replay", str(tmp_path)]) == 2
    assert "give the object's --box" in capsys.readouterr().err
