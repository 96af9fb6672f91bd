"""Control characters of files never reach the terminal, whatever prints them."""

from __future__ import annotations

import io
import json
import logging
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.table import Table

from circumspect.cli.console import OutputConsole
from circumspect.cli.main import main
from circumspect.cli.progress import bars
from circumspect.cli.visible_controls import visible, visible_controls

EVIL = "chair\x1b]0;owned\x07\x1b[2Jx\x9b31m\r"


@given(st.text())
def test_all_but_line_ends_and_tabs_is_printable(text: str) -> None:
    shown = visible(text)
    assert all(sign.isprintable() or sign in "\n\t" for sign in shown)
    if all(sign.isprintable() or sign in "\n\t" for sign in text):
        assert shown == text


def assert_harmless(text: str) -> None:
    assert "owned" in text
    assert not set(text) & set("\x1b\x07\x9b\r")


def test_control_characters_are_escaped_in_prints_and_logs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with visible_controls():
        print(EVIL)
        print(EVIL, file=sys.stderr)
        logging.getLogger("circumspect.test").warning("left out: %s", EVIL)
    printed = capsys.readouterr()
    assert_harmless(printed.out)
    assert_harmless(printed.err)
    print(EVIL)
    assert EVIL in capsys.readouterr().out


def test_tables_and_bars_show_texts_and_command_the_terminal() -> None:
    stream = io.StringIO()
    console = OutputConsole(file=stream, force_terminal=True, width=200)
    table = Table(title=EVIL)
    table.add_column(EVIL)
    table.add_row(EVIL, style="bold")
    console.print(table)
    console.print(EVIL, markup=False)
    shown = stream.getvalue()
    assert "\\x1b]0;owned" in shown
    assert "\x1b]" not in shown
    assert "\x1b[2J" not in shown
    assert "\x1b[1m" in shown, "the bold row"
    assert isinstance(bars().console, OutputConsole)


def test_labels_of_a_gathered_set_are_visible(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scan = {"scan": "a@000", "object": "a", "label": EVIL, "split": "train", "start_deg": 0.0,
            "files": {"cloud": "clouds/a@000.npz"}, "quality": {"answer": EVIL}}  # fmt: skip
    (tmp_path / "manifest.jsonl").write_text(json.dumps(scan) + "\n")
    (tmp_path / "settings.json").write_text(json.dumps({"scans": ["a@000"]}))
    assert main(["data", "verify", str(tmp_path)]) == 1
    assert_harmless(capsys.readouterr().out)
    assert main(["data", "verify", str(tmp_path), "--json"]) == 1
    out = capsys.readouterr().out
    assert_harmless(out)
    json.loads(out)
