"""Runs requested in the browser, one after the other."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from circumspect.cli.commands.scan import Scan, watched_scans
from circumspect.cli.dashboard_page import PageFlags
from circumspect.exploration import RoomSettings, ScanSettings
from circumspect.viewer import next_run
from circumspect.viewer.next_run import RunRequest

DESK = Scan(
    "desk.obj", start=30.0, seed=3, up="y", height=0.75, data=Path("own"), driving=ScanSettings(max_frames=7), world=RoomSettings(slip=0.1),
    out=Path("first"), record=Path("first.mcap"), page=PageFlags(viewer_port=0),
)  # fmt: skip


def run(monkeypatch: pytest.MonkeyPatch, *asked: RunRequest) -> list[Scan]:
    """The scans that run when these are requested one after the other, until Ctrl-C."""
    ran: list[Scan] = []
    tabs: list[next_run.NextRun] = []

    class Tab(next_run.NextRun):
        def __init__(self, *words: object) -> None:
            super().__init__(*words)  # type: ignore[arg-type]
            tabs.append(self)

    def prepared(scan: Scan, _command: str) -> object:
        return SimpleNamespace(config={"start_deg": 30.0, "planner": scan.planner})

    def scanned(scan: Scan, *_: object) -> None:
        ran.append(scan)
        if len(ran) > len(asked):
            raise KeyboardInterrupt
        tabs[0].requests.put(asked[len(ran) - 1])

    monkeypatch.setattr(next_run, "NextRun", Tab)
    monkeypatch.setattr(Scan, "prepared", prepared)
    monkeypatch.setattr(Scan, "scan", scanned)
    with pytest.raises(KeyboardInterrupt):
        watched_scans(DESK, "scan")
    return ran


def own_flags(scan: Scan) -> tuple[object, ...]:
    return scan.object, scan.up, scan.height, scan.data


def test_the_first_object_keeps_its_flags_after_other_runs(monkeypatch):
    chair, desk = RunRequest("chair", 90.0, "circle"), RunRequest("desk.obj", 10.0, "normals")
    ran = run(monkeypatch, desk, chair, chair, desk)
    mine, other = ("desk.obj", "y", 0.75, Path("own")), ("chair", None, None, None)
    assert [own_flags(scan) for scan in ran] == [mine, mine, other, other, mine]
    assert [scan.start for scan in ran] == [30.0, 10.0, 90.0, 90.0, 10.0]
    assert {(scan.driving.max_frames, scan.world.slip) for scan in ran} == {(7, 0.1)}


def test_seed_and_output_of_the_first_run_are_not_used_again(monkeypatch):
    first, *others = run(monkeypatch, *[RunRequest("desk.obj", 10.0, "circle")] * 2)
    assert (first.seed, first.out, first.record) == (3, Path("first"), Path("first.mcap"))
    assert {(scan.seed, scan.out, scan.record) for scan in others} == {(None, None, None)}
