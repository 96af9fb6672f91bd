"""Progress where standard error is no terminal: a line a minute."""

from __future__ import annotations

import pytest

from circumspect.cli import progress
from circumspect.cli.progress import progress_bar


def test_a_log_gets_a_line_a_minute_with_an_estimate(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    with progress_bar("scans") as report:
        for done in range(20, 40):  # Twenty were there before.
            report(done, 120)
            now += 30.0
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "circumspect: scans: 22 of 120, 49 min left"
    assert len(lines) == 9
    assert lines[-1] == "circumspect: scans: 38 of 120, 41 min left"


def test_work_of_less_than_a_minute_logs_nothing(capsys: pytest.CaptureFixture) -> None:
    with progress_bar("scans") as report:
        report(0, 2)
        report(2, 2)
    assert capsys.readouterr().err == ""


def test_only_the_first_of_several_processes_reports(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setenv("RANK", "1")
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    with progress_bar("scans") as report:
        for done in range(5):
            report(done, 5)
            now += 100.0
    assert capsys.readouterr().err == ""


def test_hours_and_megabytes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    with progress_bar("archive", of_bytes=True) as report:
        report(0, 500_000_000)
        now = 120.0
        report(10_000_000, 500_000_000)
    line = capsys.readouterr().err
    assert line == "circumspect: archive: 10 of 500 MB, 1 h 38 min left\n"
