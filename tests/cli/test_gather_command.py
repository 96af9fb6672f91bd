"""`circumspect gather`: simulated, and from a recording; then `data verify` and `train`."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from circumspect.cli.main import main, parsed
from circumspect.datasets.gathered_set import GatheredScan, read_manifest
from circumspect.gathering.recorded_scan import recording_name
from circumspect.gathering.set_place import SetFolder
from circumspect.geometry import read_cloud, read_tum
from circumspect.recording import RunRecorder, open_recording

SCAN = ["--frames", "4", "--frame-interval", "2"]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    flags = ["chair-3", "--seed", "1", "--start", "0", *SCAN, "--out", str(folder / "run")]
    assert main(["scan", *flags, "--record", str(folder / "first.mcap")]) == 0
    return folder / "first.mcap"


def test_a_simulated_set_is_gathered_reported_and_verified(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    out = str(tmp_path / "set")
    flags = ["--classes", "chair", "--train-objects", "1", "--test-objects", "0"]
    flags += ["--train-starts", "0", "22.5", "--workers", "1", *SCAN]
    assert main(["gather", "--out", out, *flags]) == 0
    printed = capsys.readouterr().out
    assert "chair      2     0   2 of 2" in printed
    assert "contact_sheet.png" in printed
    assert max(map(len, printed.splitlines()[:-1])) <= 80
    scans = read_manifest(tmp_path / "set")
    assert [scan.start_deg for scan in scans] == [0.0, 22.5]
    assert all(scan.quality["ate_rmse_m"] < 0.02 for scan in scans)
    assert main(["data", "verify", out]) == 0
    assert "complete" in capsys.readouterr().out
    assert main(["gather", "--config", f"{out}/config.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scans"] == 2
    (tmp_path / "set" / scans[0].files["cloud"]).unlink()
    assert main(["data", "verify", out, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["broken"][0]["file"] == scans[0].files["cloud"]


def test_recordings_are_added_with_a_label(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    out = str(tmp_path / "mine")
    flags = ["--label", "armchair", "--name", "blue", "--start", "30", "--json"]
    assert main(["gather", "--from", str(recording), "--out", out, *flags]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["counts"] == {"train/armchair": 1}
    (scan,) = read_manifest(tmp_path / "mine")
    assert (scan.scan, scan.label, scan.start_deg) == ("blue@first", "armchair", 30.0)
    assert set(scan.files) == {"cloud", "grid", "poses", "odometry"}
    assert main(["gather", "--from", str(recording), "--out", out, *flags]) == 2
    assert "holds blue@first already" in capsys.readouterr().err
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "letter.txt").write_text("")
    assert main(["gather", "--from", str(recording), "--out", str(tmp_path / "other"), *flags]) == 2
    assert "holds something else" in capsys.readouterr().err


READ = [
    "--first-pose", "0", "0", "1.2", "0", "30", "--depth-range", "0.3", "5",
    "--box", "0", "0", "0", "1", "1", "1", "--box-frame", "map", "--poses", "given", "--every", "3",
    "--depth-topic", "/d", "--info-topic", "/i", "--colour-topic", "/c", "--odometry-topic", "",
    "--map-frame", "world", "--intrinsics", "1", "1", "1", "1", "--size", "4", "3",
    "--mount", "0", "0", "1", "90", "30", "--depth-scale", "0.00025",
]  # fmt: skip


def test_a_recording_is_read_by_the_flags_of_replay() -> None:
    gathered = parsed("gather", ["--out", "set", "--from", "x.mcap", *READ]).reading
    assert gathered == parsed("replay", ["x.mcap", *READ]).reading
    assert set(gathered.changed()) == {field.name for field in fields(gathered)}, "READ lacks some"


def test_flags_for_reading_a_recording_are_used(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    command = ["gather", "--from", str(recording), "--label", "chair", "--name", "blue"]
    command += ["--out", str(tmp_path / "mine"), "--every", "2", "--odometry-topic", ""]
    assert main([*command, "--depth-topic", "/nowhere"]) == 2
    assert "contains no /nowhere (--depth-topic)" in capsys.readouterr().err
    assert not (tmp_path / "mine").exists()
    assert main([*command, "--json"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["scans"] == 1
    assert "frame   2/2" in printed.err
    (scan,) = read_manifest(tmp_path / "mine")
    assert set(scan.files) == {"cloud", "grid", "poses"}
    assert scan.quality["frames"] == 2
    assert scan.quality["reading"] == {"every": 2, "odometry_topic": ""}


def test_a_folder_with_poses_and_a_box_is_a_recording_too(recording: Path, tmp_path: Path) -> None:
    run, folder = tmp_path / "run", tmp_path / "seven"
    assert main(["replay", str(recording), "--out", str(run)]) == 0
    points = read_cloud(run / "model.ply").points_xyz
    box = [f"{value:.3f}" for value in (*points.min(axis=0), *points.max(axis=0))]
    folder.mkdir()
    poses = read_tum(run / "trajectory.txt").T_map_camera
    for number, frame in enumerate(open_recording(recording)):
        stem = folder / f"frame-{number:06d}"
        millimetres = np.rint(np.nan_to_num(frame.depth) * 1000).astype(np.uint16)
        Image.fromarray(millimetres).save(f"{stem}.depth.png")
        np.savetxt(f"{stem}.pose.txt", poses[number].as_matrix())
        c = frame.camera
        matrix = [[c.fx, 0, c.cx], [0, c.fy, c.cy], [0, 0, 1]]
        np.savetxt(folder / "camera-intrinsics.txt", matrix)
    np.savetxt(folder / "gravity-direction.txt", [0, 0, -1])
    command = ["gather", "--from", str(folder), "--label", "chair", "--out", str(tmp_path / "mine")]
    assert main(command) == 2
    assert main([*command, "--box", *box, "--box-frame", "map"]) == 0
    (scan,) = read_manifest(tmp_path / "mine")
    assert set(scan.files) == {"cloud", "grid", "poses"}


def test_a_recording_that_shows_nothing_is_refused(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    blind = tmp_path / "blind" / "first.mcap"
    blind.parent.mkdir()
    recorder = RunRecorder(blind, {})
    for frame in open_recording(recording):
        recorder.frame(replace(frame, depth=np.full_like(frame.depth, np.nan)))
    recorder.close()
    out = str(tmp_path / "mine")
    flags = ["--label", "chair", "--name", "blue", "--out", out]
    assert main(["gather", "--from", str(blind), *flags]) == 2
    complaint = capsys.readouterr().err.splitlines()[-1]
    assert "shows no object in 4 frames (no depth in the frame); nothing was added" in complaint
    assert not (tmp_path / "mine").exists()
    # Sets of earlier versions hold such scans: the mended recording takes their place.
    SetFolder(tmp_path / "mine").begin({"source": "recordings"})
    SetFolder(tmp_path / "mine").add(GatheredScan("blue@first", "blue", "chair", "train", None))
    assert main(["gather", "--from", str(recording), *flags]) == 0
    (scan,) = read_manifest(tmp_path / "mine")
    assert "cloud" in scan.files


def test_replace_corrects_a_wrong_label(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    out = str(tmp_path / "mine")
    flags = ["gather", "--from", str(recording), "--name", "blue", "--out", out]
    assert main([*flags, "--label", "sofa"]) == 0
    right = [*flags, "--label", "chair", "--odometry-topic", ""]
    assert main(right) == 2
    assert "holds blue@first already, of first.mcap; --replace puts" in capsys.readouterr().err
    assert main([*right, "--replace"]) == 0
    (scan,) = read_manifest(tmp_path / "mine")
    assert scan.label == "chair"
    assert main(["data", "verify", out, "--json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["foreign"] == []
    second = recording.with_name("second.mcap")
    second.write_bytes(recording.read_bytes())
    assert main([*flags, "--from", str(second), "--label", "sofa", "--replace"]) == 2
    assert "blue is a chair of the train split there, as in blue@first" in capsys.readouterr().err


def test_replace_corrects_the_label_of_all_recordings_of_an_object(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    second = recording.with_name("second.mcap")
    second.write_bytes(recording.read_bytes())
    flags = ["gather", "--name", "blue", "--out", str(tmp_path / "mine")]
    for path in (recording, second):
        assert main([*flags, "--from", str(path), "--label", "sofa"]) == 0
    capsys.readouterr()
    right = ["--from", str(second), "--label", "chair", "--split", "test", "--replace"]
    assert main([*flags, *right]) == 0
    change = "chair of the test split now, was sofa of the train split"
    assert f"blue@first, blue@second: {change}" in capsys.readouterr().err
    scans = read_manifest(tmp_path / "mine")
    assert {(scan.scan, scan.label, scan.split) for scan in scans} == {
        ("blue@first", "chair", "test"), ("blue@second", "chair", "test"),
    }  # fmt: skip


def test_an_object_stays_in_its_split_unless_another_is_given(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    second = recording.with_name("second.mcap")
    second.write_bytes(recording.read_bytes())
    flags = ["gather", "--name", "red", "--out", str(tmp_path / "mine"), "--from"]
    assert main([*flags, str(recording), "--label", "toilet", "--split", "test"]) == 0
    assert main([*flags, str(second), "--label", "toilet"]) == 0
    capsys.readouterr()
    right = [*flags, str(recording), "--label", "chair", "--replace"]
    change = "red@first, red@second: chair of the {} split now, was {} of the test split"
    for split, was, now in (([], "toilet", "test"), (["--split", "train"], "chair", "train")):
        assert main([*right, *split]) == 0
        assert change.format(now, was) in capsys.readouterr().err
        scans = read_manifest(tmp_path / "mine")
        assert [(s.label, s.split) for s in scans] == [("chair", now)] * 2


def test_a_folder_recording_keeps_its_whole_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    walk = tmp_path / "walk_2024.01.05"
    walk.mkdir()
    (tmp_path / "run.01.mcap").touch()
    assert recording_name(walk) == "walk_2024.01.05"
    assert recording_name(tmp_path / "run.01.mcap") == "run.01"
    monkeypatch.chdir(walk)
    assert recording_name(Path()) == "walk_2024.01.05"


def test_scans_that_saw_nothing_are_reported(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    out = str(tmp_path / "set")
    flags = ["--classes", "chair", "--train-objects", "1", "--test-objects", "0"]
    flags += ["--workers", "1"]
    assert main(["gather", "--out", out, *flags, *SCAN]) == 0
    assert "never saw" not in capsys.readouterr().out
    SetFolder(tmp_path / "set").add(GatheredScan("chair-1@045", "chair-1", "chair", "train", 45.0))
    assert main(["gather", "--out", out, *flags, *SCAN]) == 0
    assert "1 of them never saw their object; circumspect data verify" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("flags", "reason"),
    [
        (["--from", "run.mcap"], "needs the --label"),
        (["--from", "missing.mcap", "--label", "chair"], "can not be read"),
        (["--label", "chair"], "goes with --from"),
        (["--classes", "unicorn"], "no source has objects of class unicorn"),
        (["--sources", "nowhere"], "nowhere: "),
        (["--train-objects", "0", "--test-objects", "0"], "at least one object"),
        (["--workers", "0"], "at least one process"),
        (["--from", "x.mcap", "--label", "../up"], "a name is made of letters"),
    ],
)
def test_errors_are_one_line(
    flags: list[str], reason: str, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    assert main(["gather", "--out", str(tmp_path / "set"), *flags]) == 2
    error = capsys.readouterr().err
    assert reason in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize(
    ("flags", "error"),
    [
        (["--start", "90"], "--start goes with --from"),
        (["--replace"], "--replace goes with --from"),
        (["--depth-topic", "/d"], "--depth-topic goes with --from"),
        (["--box", "0", "0", "0", "1", "1", "1"], "--box goes with --from"),
        (
            ["--from", "x.mcap", "--label", "chair", "--train-starts", "45"],
            "--train-starts is for simulated scans",
        ),
        (["--from", "x.mcap", "--label", "chair", "--frames", "5"], "--frames is for simulated"),
        (["--test-starts", "45", "45.04"], "a tenth of a degree apart"),
    ],
)
def test_flags_that_would_be_ignored_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture, flags: list[str], error: str
) -> None:
    assert main(["gather", "--out", str(tmp_path / "set"), *flags]) == 2
    assert error in capsys.readouterr().err
    assert not (tmp_path / "set").exists()
