"""Runs that begin in the same second."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from circumspect.cli import run_screen
from circumspect.cli.main import main
from circumspect.cli.run_screen import new_run_folder


def test_each_run_has_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with ThreadPoolExecutor(8) as pool:
        folders = list(pool.map(new_run_folder, ["scan"] * 40))
    assert len({*folders}) == 40
    assert {*Path("runs").iterdir()} == {*folders}
    assert all(folder.name.startswith("scan-2") for folder in folders)


def test_existing_folders_are_numbered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Noon(run_screen.datetime):
        @classmethod
        def now(cls, tz=None) -> Noon:
            return cls(2026, 1, 2, 12, 0, 0, tzinfo=tz)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(run_screen, "datetime", Noon)
    names = [new_run_folder("track").name for _ in range(2)]
    (tmp_path / "runs" / "track-20260102-120000-3").symlink_to("gone")
    names.append(new_run_folder("track").name)
    assert names == [f"track-20260102-120000{end}" for end in ("", "-2", "-4")]


def test_an_unwritable_runs_folder_is_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").write_text("mine")
    assert main(["locate", "simulate", "--seconds", "1"]) == 2
    out, err = capsys.readouterr()
    assert "runs/locate-2" in err
    assert "can not be written" in err
    assert (out, err.count("\n")) == ("", 1)
    assert (tmp_path / "runs").read_text() == "mine"
