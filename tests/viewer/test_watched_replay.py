"""A recording in the dashboard: played, paused, and shown to its end."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("viser", reason="viser is not installed")
pytest.importorskip("embreex", reason="the simulation is not installed")

from test_dashboard_page import LONG, command, frame_shown, opened, press, until, wait_for_line

from circumspect.classification import Classifier
from circumspect.cli.commands.replay import Replay
from circumspect.cli.commands.scan import Scan
from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.watched_replay import ReplayWatch
from circumspect.exploration import ScanSettings
from circumspect.viewer import Dashboard


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    file = folder / "run.mcap"
    scan = Scan(
        object="chair-3", start=40.0, seed=5, driving=ScanSettings(frame_interval=2.0, max_frames=6), json=True,
        out=folder / "run", record=file,
    )  # fmt: skip
    assert scan.run() == 0
    return file


def test_a_watched_replay_gives_the_result_of_a_plain_one(recording, tmp_path, capsys):
    with Dashboard(Classifier.load(), port=0) as dashboard:
        published = []
        dashboard.put = published.append
        replay = Replay(recording=recording, out=tmp_path / "watched", page=PageFlags(0))
        replay.replay(ReplayWatch(dashboard))
    watched = capsys.readouterr().out
    Replay(recording=recording, out=tmp_path / "plain").run()
    assert watched.splitlines()[0] == capsys.readouterr().out.splitlines()[0]
    shown = published[-1]()
    assert shown.message == "the run is over: the end of the recording"
    assert shown.count == len(shown.path_xyz) == 6
    assert shown.row["label"] == "chair"


def test_a_replay_can_be_paused_and_its_page_stays(browser, recording, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with (
        command("replay", str(recording), "--viewer") as (process, url, _),
        opened(browser, url) as (page, faults),
    ):
        press(page, page.get_by_role("button", name="Pause"))
        page.get_by_role("button", name="Go on").wait_for(timeout=LONG)
        press(page, page.get_by_role("button", name="Go on"))
        until(page, lambda: frame_shown(page) == 6)
        page.get_by_text("the run is over: the end of the recording").wait_for(timeout=LONG)
        assert page.locator("#circumspect-label").inner_text() == "chair"
        assert page.get_by_role("tab", name="New run").count() == 0
        wait_for_line(process, "the page stays open")
        assert faults == []
    assert process.returncode == 0
    assert len(list((tmp_path / "runs").iterdir())) == 1
