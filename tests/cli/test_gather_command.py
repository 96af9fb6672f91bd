"""`circumspect gather`: simulated, and from a recording; then `data verify` and `train`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from circumspect.cli.main import main
from circumspect.datasets.gathered_set import read_manifest

SCAN = ["--frames", "4", "--frame-interval", "2"]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    flags = ["chair-3", "--seed", "1", "--start", "0", *SCAN, "--out", str(folder / "run")]
    assert main(["scan", *flags, "--record", str(folder / "first.mcap")]) == 0
    return folder / "first.mcap"


def test_a_simulated_set_is_made_told_and_verified(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    out = str(tmp_path / "set")
    flags = ["--classes", "chair", "--objects", "1", "--at", "0", "22.5", "--workers", "1", *SCAN]
    assert main(["gather", "--out", out, *flags]) == 0
    told = capsys.readouterr().out
    assert "chair                2       0" in told
    assert "contact_sheet.png" in told
    assert max(map(len, told.splitlines()[:-1])) <= 80
    scans = read_manifest(tmp_path / "set")
    assert [scan.start_deg for scan in scans] == [0.0, 22.5]
    assert all(scan.quality["ate_rmse_m"] < 0.02 for scan in scans)
    assert main(["data", "verify", out]) == 0
    assert "complete" in capsys.readouterr().out
    (tmp_path / "set" / scans[0].files["cloud"]).unlink()
    assert main(["data", "verify", out, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["broken"][0]["file"] == scans[0].files["cloud"]


def test_recordings_are_added_with_a_label(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    out = str(tmp_path / "mine")
    flags = ["--label", "armchair", "--name", "blue", "--start", "30", "--json"]
    assert main(["gather", "--from", str(recording), "--out", out, *flags]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["counts"] == {"train/armchair": 1}
    (scan,) = read_manifest(tmp_path / "mine")
    assert (scan.scan, scan.label, scan.start_deg) == ("blue@first", "armchair", 30.0)
    assert set(scan.files) == {"cloud", "grid", "poses", "odometry"}
    assert main(["gather", "--from", str(recording), "--out", out, *flags]) == 2
    assert "holds blue@first already" in capsys.readouterr().err
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "letter.txt").write_text("")
    assert main(["gather", "--from", str(recording), "--out", str(tmp_path / "other"), *flags]) == 2
    assert "holds something else" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--from", "run.mcap"], "needs the --label"),
        (["--from", "missing.mcap", "--label", "chair"], "can not be read"),
        (["--label", "chair"], "goes with --from"),
        (["--classes", "unicorn"], "no furniture called unicorn"),
        (["--starts", "0"], "at least one start"),
        (["--workers", "0"], "at least one process"),
        (["--from", "x.mcap", "--label", "../up"], "a name is made of letters"),
    ],
)
def test_mistakes_are_told_in_a_line(
    flags: list[str], says: str, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    assert main(["gather", "--out", str(tmp_path / "set"), *flags]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        (["--start", "90"], "--start goes with --from"),
        (["--from", "x.mcap", "--label", "chair", "--at", "0"], "--at is for simulated scans"),
        (["--from", "x.mcap", "--label", "chair", "--frames", "-5"], "--frames is for simulated"),
        (["--at", "45", "45.04"], "a tenth of a degree apart"),
    ],
)
def test_flags_that_would_be_ignored_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture, flags: list[str], told: str
) -> None:
    assert main(["gather", "--out", str(tmp_path / "set"), *flags]) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "set").exists()
