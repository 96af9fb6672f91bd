"""The page in a real browser: it loads, plays, rotates the object, and stays free of errors."""

from __future__ import annotations

import io
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("viser", reason="viser is not installed")

LONG = 60_000
"""[ms]"""
FRAME = re.compile(r"frame (\d+),")


@contextmanager
def command(*words: str) -> Iterator[tuple[subprocess.Popen[str], str, list[str]]]:
    """A command with a dashboard, its address, and its output so far; ended by Ctrl-C."""
    process = subprocess.Popen(
        [sys.executable, "-m", "circumspect", *words, "--viewer-port", "0"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    output: list[str] = []
    # Reading the output blocks: a process that hangs is ended.
    watchdog = threading.Timer(240, process.kill)
    watchdog.start()
    try:
        assert process.stderr is not None
        for line in process.stderr:
            output.append(line)
            if found := re.search(r"http://\S+?(?=;)", line):
                yield process, found[0], output
                break
        else:
            pytest.fail("".join(output))
    finally:
        watchdog.cancel()
        process.send_signal(signal.SIGINT)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()
        process.stderr.close()


@contextmanager
def opened(browser, url: str):
    """A page, and its errors and requests to other hosts."""
    page = browser.new_page(viewport={"width": 900, "height": 700})
    faults: list[str] = []
    page.on("console", lambda entry: faults.append(entry.text) if entry.type == "error" else None)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on(
        "request",
        lambda sent: (
            None
            if sent.url.startswith((url, "data:", "blob:"))
            else faults.append(f"asked for {sent.url}")
        ),
    )
    page.goto(url)
    yield page, faults
    page.close()


def frame_shown(page) -> int:
    return int(FRAME.search(page.get_by_text(FRAME).first.inner_text())[1])


def press(page, control) -> None:
    """By keyboard: the panel may move during a run."""
    until(page, control.is_enabled)
    control.focus()
    page.keyboard.press("Enter")


def until(page, condition, seconds: float = LONG / 1e3) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, page.inner_text("body")[:1000]
        page.wait_for_timeout(50)


def drawn(page) -> int:
    """How many colours the 3D view has."""
    shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    pixels = np.asarray(shot)[150:, :450].reshape(-1, 3)
    return len(np.unique(pixels, axis=0))


def test_a_finished_run_plays_and_keeps_its_answer_under_rotation(browser, finished_run):
    with (
        command("view", str(finished_run)) as (process, url, _),
        opened(browser, url) as (page, faults),
    ):
        page.locator("#circumspect-label").wait_for(timeout=LONG)
        assert page.locator("#circumspect-label").inner_text() == "chair"

        # It plays to its end.
        until(page, lambda: frame_shown(page) == 6)
        page.get_by_role("button", name="Play").wait_for(timeout=LONG)

        # The time bar brings an earlier frame back.
        bar = page.get_by_role("slider").first
        bar.focus()
        page.keyboard.press("Home")
        until(page, lambda: frame_shown(page) == 1)

        # A rotation makes a new grid, and the answer stays.
        turn = page.get_by_role("slider").nth(1)
        turn.focus()
        for _ in range(7):
            page.keyboard.press("ArrowRight")
        page.get_by_text("turned by 7°: the answer stays").wait_for(timeout=LONG)
        assert page.locator("#circumspect-turned").inner_text() == "chair"
        assert page.locator("#circumspect-label").inner_text() == "chair"

        until(page, lambda: drawn(page) > 300)
        assert faults == []
    assert process.returncode == 0


def test_an_exported_run_plays_without_a_network(browser, finished_run, tmp_path, capsys):
    from circumspect.cli.main import main

    file = tmp_path / "run.html"
    assert main(["view", str(finished_run), "--export", str(file)]) == 0
    assert capsys.readouterr().out.startswith(str(file))
    assert file.stat().st_size < 20e6
    with opened(browser, file.as_uri()) as (page, faults):
        until(page, lambda: page.locator("#circumspect-label").count() == 1)
        assert page.locator("#circumspect-label").inner_text() == "chair"
        until(page, lambda: frame_shown(page) == 6)
        until(page, lambda: drawn(page) > 300)
        assert page.title() == "circumspect: chair-3"
        assert faults == []


def test_a_live_run_is_controlled_replaced_and_goes_on_without_a_browser(
    browser, tmp_path, monkeypatch
):
    pytest.importorskip("embreex", reason="the simulation is not installed")
    monkeypatch.chdir(tmp_path)
    words = ("scan", "chair-3", "--start", "40", "--seed", "5", "--frame-interval", "2")
    with command(*words, "--viewer") as (process, url, _):
        with opened(browser, url) as (page, faults):
            # Paused, it takes no frame; one frame is one frame.
            press(page, page.get_by_role("button", name="Pause"))
            page.get_by_role("button", name="Go on").wait_for(timeout=LONG)
            page.wait_for_timeout(1500)
            paused = frame_shown(page)
            page.wait_for_timeout(500)
            assert frame_shown(page) == paused
            press(page, page.get_by_role("button", name="One frame"))
            until(page, lambda: frame_shown(page) == paused + 1)

            # A covered camera is reported.
            page.get_by_role("checkbox").first.focus()
            page.keyboard.press("Space")
            page.wait_for_timeout(300)
            press(page, page.get_by_role("button", name="One frame"))
            until(page, lambda: frame_shown(page) == paused + 2)
            press(page, page.get_by_role("tab", name="Stages"))
            page.get_by_text("no depth in the frame").first.wait_for(timeout=LONG)

            # Another run, from elsewhere, takes the place of this one.
            press(page, page.get_by_role("tab", name="New run"))
            page.get_by_role("slider").last.focus()
            page.keyboard.press("End")
            page.wait_for_timeout(300)
            press(page, page.get_by_role("button", name="Start", exact=True))
            wait_for_line(process, "from 360°")
            press(page, page.get_by_role("button", name="Pause"))
            page.get_by_role("button", name="Go on").wait_for(timeout=LONG)
            assert faults == []
        # Without a browser the paused run resumes.
        newest = max((tmp_path / "runs").iterdir(), key=lambda folder: folder.stat().st_ctime)
        lines = frames_logged(newest)
        end = time.monotonic() + LONG / 1e3
        while frames_logged(newest) < lines + 3:
            assert time.monotonic() < end, "the run does not go on"
            time.sleep(0.05)
    assert process.returncode == 130
    assert len(list((tmp_path / "runs").iterdir())) == 2


def wait_for_line(process, words: str) -> None:
    for line in process.stderr:
        if words in line:
            return
    pytest.fail(f"it never said: {words}")


def frames_logged(folder) -> int:
    return len((folder / "log.jsonl").read_text().splitlines())


def test_an_address_other_than_loopback_gives_a_warning(finished_run):
    words = ("view", str(finished_run), "--viewer-host", "0.0.0.0")
    with command(*words) as (process, url, output):
        assert url.startswith("http://127.0.0.1:")
        assert "warning" in "".join(output)
    assert process.returncode == 0
