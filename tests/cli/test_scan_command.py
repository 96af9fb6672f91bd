"""`circumspect scan`: its flags, its output and its files."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from circumspect.classification.shipped import shipped_path
from circumspect.cli.commands.scan import Scan, _how_to_repeat
from circumspect.cli.main import main, parsed
from circumspect.errors import CircumspectError, InputError
from circumspect.exploration import ScanSettings
from circumspect.geometry import read_cloud
from circumspect.planning import ConfidencePlanner
from circumspect.sensing import RgbdFrame
from circumspect.simulation import SimulatedRobot

FEW = Scan(
    object="chair-3", start=40.0, seed=5, driving=ScanSettings(frame_interval=2.0, max_frames=3)
)


def few(frames):
    return ScanSettings(frame_interval=2.0, max_frames=frames)


def typed(**flags) -> Scan:
    """`FEW` but for some flags, as the command line makes it."""
    given = {"start": 40.0, "seed": 5, "frames": 3, "frame_interval": 2.0, **flags}
    name_of_object = given.pop("object", "chair-3")
    return parsed(
        "scan",
        [name_of_object, *(f"--{name.replace('_', '-')}={value}" for name, value in given.items())],
    )


FIELDS = [
    "object", "true_label", "start_deg",
    "label", "in_distribution", "in_distribution_probability", "confident", "reason",
    "probability", "probabilities",
    "alternatives", "truth", "frames", "outcomes", "lost_from", "coverage", "points", "interrupted",
    "end_reason", "milliseconds",
    "distance_m", "ate_rmse_m", "ate_odometry_rmse_m", "yaw_rmse_deg", "chamfer_m", "completeness",
    "run", "ended",
]  # fmt: skip


def test_json_is_one_line_with_exactly_these_fields(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    assert replace(FEW, out=out, json=True).run() == 0
    printed = capsys.readouterr()
    assert printed.out.count("\n") == 1
    record = json.loads(printed.out)
    assert list(record) == FIELDS
    assert record["object"] == "chair-3"
    assert record["frames"] == 3
    assert record["chamfer_m"] < 0.02
    assert 0 < record["completeness"] <= 1
    assert set(record["milliseconds"]["frame"]) == {"median", "p95"}
    assert record["probabilities"][record["label"]] == record["probability"]
    assert record["truth"] == record["true_label"] == "chair"
    assert {file.name for file in out.iterdir()} >= {
        "config.json", "log.jsonl", "result.json", "scan.json", "model.ply", "grid.npz",
        "trajectory.txt", "picture.png",
    }  # fmt: skip
    result = json.loads((out / "result.json").read_text())
    assert {name: record[name] for name in result} == result
    assert "plan" in result["milliseconds"]
    assert result["points"] == len(read_cloud(out / "model.ply").points_xyz) > 0
    scan = json.loads((out / "scan.json").read_text())
    assert scan["ended"] == record["ended"]
    assert scan["measured"]["ate_rmse_m"] == record["ate_rmse_m"]
    config = json.loads((out / "config.json").read_text())
    assert config["scan"]["frame_interval"] == 2.0
    assert config["room"]["slip"] == 0.05


def test_sentences_fit_narrow_terminals(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.chdir(tmp_path)
    replace(FEW, driving=few(8), out=Path("run")).run()
    printed = capsys.readouterr()
    assert printed.out.startswith("Result: ")
    assert "the limit of 8 frames is reached" in printed.out
    assert "Its path was known within" in printed.out
    assert "chair-3 from 40°, seed 5, a frame each 10 cm" in printed.err
    assert max(map(len, (printed.out + printed.err).splitlines())) <= 80


def test_the_same_seed_gives_the_same_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("one", "two"):
        replace(FEW, object="sofa", start=None, out=tmp_path / name, json=True).run()
    first, second = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    for record in (first, second):
        del record["milliseconds"], record["run"]
    assert first == second


def test_a_chair_is_named_from_two_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for start in (40.0, 220.0):
        command = replace(FEW, start=start, driving=few(30), planner="confidence", json=True)
        replace(command, out=tmp_path / f"{start}").run()
    records = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [record["label"] for record in records] == ["chair", "chair"]
    for record in records:
        assert record["ate_rmse_m"] < 0.02
        assert record["chamfer_m"] < 0.01


def test_a_mesh_file_is_scanned(
    chair_obj: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["scan", str(chair_obj), "--up", "y", "--height", "0.9", "--seed", "1"]
    more = ["--no-clutter", "--planner", "circle", "--slip", "0", "--frames", "2", "--json"]
    (tmp_path / "own.onnx").write_bytes(shipped_path("modelnet10").read_bytes())
    more += ["--model", str(tmp_path / "own.onnx")]
    assert main([*words, *more, "--out", str(tmp_path / "run")]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["true_label"] is None
    assert record["label"] is not None
    config = json.loads((tmp_path / "run" / "config.json").read_text())
    assert config["room"]["clutter"] is False
    assert (config["up"], config["height"]) == ("y", 0.9)
    assert config["classifier"]["model"].endswith("own.onnx")
    assert len(config["classifier"]["sha256"]) == 64


def test_ridges_and_unequal_wheels_leave_the_tracked_poses_accurate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["scan", "chair-3", "--seed", "2", "--speed", "0.2", "--frames", "24", "--json"]
    faults = ["--bumps", "0.005", "--wheel-error", "0.05", "--no-clutter"]
    assert main([*words, *faults, "--out", str(tmp_path)]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["ate_rmse_m"] < 0.01
    assert record["ate_odometry_rmse_m"] > 0.02
    config = json.loads((tmp_path / "config.json").read_text())
    assert (config["room"]["bump_height"], config["room"]["wheel_error"]) == (0.005, 0.05)


def test_real_time_keeps_the_frame_interval(tmp_path: Path) -> None:
    began = time.monotonic()
    words = ["scan", "chair-3", "--frames", "4", "--no-clutter", "--real-time"]
    assert main([*words, "--out", str(tmp_path)]) == 0
    assert time.monotonic() - began > 3 * 0.5, "half a second between two frames"


def test_frames_without_depth_are_counted_in_the_answer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    observe, taken = SimulatedRobot.observe, []

    def blind_second(robot: SimulatedRobot) -> RgbdFrame:
        frame = observe(robot)
        taken.append(frame)
        blind = np.full_like(frame.depth, np.nan)
        return replace(frame, depth=blind) if len(taken) == 2 else frame

    monkeypatch.setattr(SimulatedRobot, "observe", blind_second)
    assert replace(FEW, out=tmp_path / "run").run() == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "Frames that are not part of it: no depth in the frame (1). It drove" in printed


def test_a_scan_without_an_answer_is_no_success(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    observe = SimulatedRobot.observe

    def blind(robot: SimulatedRobot) -> RgbdFrame:
        frame = observe(robot)
        return replace(frame, depth=np.full_like(frame.depth, np.nan))

    monkeypatch.setattr(SimulatedRobot, "observe", blind)
    assert replace(FEW, out=tmp_path / "run").run() == 1
    assert "No answer after 3 frames: no depth in the frame." in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "flag"),
    [
        ({"slip": 0.9}, "--slip"), ({"wheel_error": 0.5}, "--wheel-error"),
        ({"bumps": 0.06}, "--bumps"), ({"speed": 9.0}, "--speed"),
        ({"frame_interval": 0.0}, "--frame-interval"), ({"mast_height": -1.0}, "--mast-height"),
        ({"tilt": 95.0}, "--tilt"), ({"tilt": float("nan")}, "--tilt"),
    ],
)  # fmt: skip
def test_a_value_out_of_range_names_its_flag(wrong: dict, flag: str) -> None:
    with pytest.raises(InputError, match=f"^{flag}: "):
        typed(**wrong).prepared("scan")


@pytest.mark.parametrize(
    "wrong",
    [
        {"frames": 0}, {"seed": -1}, {"start": float("nan")}, {"speed": 0.0}, {"speed": 9.0},
        {"frame_interval": 0.0}, {"slip": 0.9}, {"slip": -0.1}, {"mast_height": -1.0},
        {"mast_height": 0.001}, {"mast_height": float("nan")}, {"mast_height": float("inf")},
        {"bumps": 0.06}, {"bumps": -0.01}, {"wheel_error": 0.5}, {"wheel_error": float("nan")},
        {"tilt": 95.0}, {"height": 0.5}, {"object": "chiar"}, {"model": "none.onnx"},
    ],
)  # fmt: skip
def test_flags_out_of_range_are_refused_before_anything_is_written(
    tmp_path: Path, wrong: dict, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CircumspectError):
        typed(**wrong).run()
    assert list(tmp_path.iterdir()) == []


def test_an_object_too_large_for_the_camera_is_refused(
    chair_obj: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scan", str(chair_obj), "--up", "y", "--seed", "0"]) == 2
    stderr = capsys.readouterr().err
    assert stderr.count("\n") == 1
    assert stderr.endswith("are its units metres? --height scales it to a height in metres\n")


def test_ctrl_c_saves_the_run_and_prints_its_folder(
    tmp_path: Path, ctrl_c_at: Callable[[int], None], capsys: pytest.CaptureFixture[str]
) -> None:
    ctrl_c_at(3)
    out = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        replace(FEW, driving=few(9), out=out).run()
    assert json.loads((out / "result.json").read_text())["interrupted"] is True
    assert json.loads((out / "scan.json").read_text())["ended"] == "interrupted"
    assert json.loads((out / "result.json").read_text())["end_reason"] is None
    assert str(out) in capsys.readouterr().err.replace("\n", "")


@pytest.mark.parametrize("command", ["scan chair-3", "demo"])
def test_ctrl_c_reports_the_drawn_seed(
    command: str,
    tmp_path: Path,
    ctrl_c_at: Callable[[int], None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    ctrl_c_at(2)
    assert main([*command.split(), "--out", str(tmp_path)]) == 130
    config = json.loads((tmp_path / "config.json").read_text())
    line = capsys.readouterr().err.splitlines()[-1]
    again = f"the same command with --seed {config['seed']} starts the same run again"
    assert line == f"circumspect: interrupted; {again}"


def test_a_run_chosen_on_the_dashboard_is_repeated_with_all_its_choices() -> None:
    parts = replace(FEW, planner="circle").prepared("demo")
    assert _how_to_repeat(parts.config, chosen_there=True) == (
        "circumspect scan chair-3 --start 40.0 --seed 5 --planner circle --frame-interval 2.0 and "
        "the other flags start the same run again"
    )


@pytest.mark.parametrize("planner", ["normals", "circle"])
def test_every_planner_can_stop_when_the_answer_is_confident(
    planner: Literal["normals", "circle"],
) -> None:
    command = replace(FEW, planner=planner)
    assert not isinstance(command._planner(), ConfidencePlanner)
    assert isinstance(replace(command, stop_when_sure=True)._planner(), ConfidencePlanner)
