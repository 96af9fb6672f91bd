"""Runs that are asked for in the browser, one after the other."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.scan import Scan
from circumspect.cli.watched_scan import watched_scans
from circumspect.viewer import next_run
from circumspect.viewer.next_run import RunRequest

DESK = Scan(
    "desk.obj", start=30.0, seed=3, up="y", height=0.75, data=Path("own"), frames=7, slip=0.1,
    out=Path("first"), record=Path("first.mcap"), page=PageFlags(viewer_port=0),
)  # fmt: skip


def run(monkeypatch: pytest.MonkeyPatch, *asked: RunRequest) -> list[Scan]:
    """The scans that were run, when one after the other is asked for and then Ctrl-C pressed."""
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


def test_the_first_object_keeps_its_flags_whatever_was_run_in_between(monkeypatch):
    chair, desk = RunRequest("chair", 90.0, "circle"), RunRequest("desk.obj", 10.0, "normals")
    ran = run(monkeypatch, desk, chair, chair, desk)
    mine, other = ("desk.obj", "y", 0.75, Path("own")), ("chair", None, None, None)
    assert [own_flags(scan) for scan in ran] == [mine, mine, other, other, mine]
    assert [scan.start for scan in ran] == [30.0, 10.0, 90.0, 90.0, 10.0]
    assert {(scan.frames, scan.slip) for scan in ran} == {(7, 0.1)}


def test_what_was_named_for_the_first_run_is_not_for_the_next(monkeypatch):
    first, *others = run(monkeypatch, *[RunRequest("desk.obj", 10.0, "circle")] * 2)
    assert (first.seed, first.out, first.record) == (3, Path("first"), Path("first.mcap"))
    assert {(scan.seed, scan.out, scan.record) for scan in others} == {(None, None, None)}
