from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from circumspect.cli.commands.demo import FRAME_INTERVAL, Demo
from circumspect.cli.main import main
from circumspect.errors import InputError, WeightsError
from circumspect.exploration import ScanSettings
from circumspect.grid import OccupancyGrid


def few(frames: int) -> ScanSettings:
    return ScanSettings(frame_interval=FRAME_INTERVAL, max_frames=frames)


def test_json_is_one_line_and_repeats_the_run_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    assert Demo(object="chair", start=135.0, seed=3, driving=few(4), out=out, json=True).run() == 0
    printed = capsys.readouterr()
    record = json.loads(printed.out)
    assert printed.out.count("\n") == 1
    assert (record["true_label"], record["start_deg"]) == ("chair", 135.0)
    assert record["run"] == str(out)
    assert record["frames"] == 4
    assert record["ended"] == "the limit of 4 frames is reached"
    assert set(record["milliseconds"]) == {
        "segment", "register", "fuse", "grid", "classify", "plan", "frame",
    }  # fmt: skip
    config = json.loads((out / "config.json").read_text())
    assert (config["command"], config["seed"]) == ("demo", 3)
    assert record["label"] == json.loads((out / "result.json").read_text())["label"]
    assert "frame   1" in printed.err
    assert (out / "picture.png").exists()
    assert (out / "scan.json").exists()


def test_the_same_seed_gives_the_same_run_and_flags_do_not_change_the_rest(tmp_path: Path) -> None:
    grids, configs = [], []
    for name, start in (("one", None), ("same", None), ("turned", 77.0)):
        out = tmp_path / name
        Demo(seed=11, driving=few(2), out=out, start=start).run()
        grids.append(OccupancyGrid.load(out / "grid.npz"))
        configs.append(json.loads((out / "config.json").read_text()))
    np.testing.assert_array_equal(grids[0].states, grids[1].states)
    assert grids[0].grid == grids[1].grid
    assert configs[0] == configs[1]
    assert configs[2]["object"] == configs[0]["object"]
    assert configs[2]["start_deg"] == 77.0


def test_without_a_seed_one_is_drawn_that_repeats_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Demo(driving=few(1), out=tmp_path / "one", json=True).run()
    seed = json.loads((tmp_path / "one" / "config.json").read_text())["seed"]
    Demo(driving=few(1), out=tmp_path / "two", seed=seed, json=True).run()
    again = ["demo", "--config", str(tmp_path / "one" / "config.toml")]
    assert main([*again, "--out", str(tmp_path / "three")]) == 0
    first, *others = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert len(others) == 2
    for second in others:
        for name in ("object", "start_deg", "probability"):
            assert first[name] == second[name]


def test_default_folder_is_below_runs_in_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        Demo(object="toilet", seed=1, driving=few(1)).run()
    folders = sorted((tmp_path / "runs").iterdir())
    assert len(folders) == 2
    assert all(folder.name.startswith("demo-") for folder in folders)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("Result: ")
    assert "the limit of 1 frames is reached" in " ".join(lines)
    assert "picture.png" in lines[-1]


def test_unknown_object_lists_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'chiar'.*bathtub, bed, chair"):
        Demo(object="chiar", out=tmp_path).run()


@pytest.mark.parametrize(
    "flag", ["--frames=0", "--frames=-3", "--seed=-1", "--start=nan", "--start=inf"]
)
def test_flags_out_of_range_are_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], flag: str
) -> None:
    words = ["demo", "--frames=1", flag, "--out", str(tmp_path / "run")]
    assert main(words) == 2
    assert flag.split("=")[0] in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_a_missing_model_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(WeightsError, match=r"none\.onnx"):
        Demo(model=str(tmp_path / "none.onnx"), out=tmp_path / "run").run()


def test_ctrl_c_saves_the_run_and_prints_its_folder(
    tmp_path: Path, ctrl_c_at: Callable[[int], None], capsys: pytest.CaptureFixture[str]
) -> None:
    ctrl_c_at(3)
    out = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        Demo(object="chair", seed=0, driving=few(9), out=out).run()
    record = json.loads((out / "result.json").read_text())
    assert (record["frames"], record["interrupted"]) == (2, True)
    assert str(out) in capsys.readouterr().err.replace("\n", "")
