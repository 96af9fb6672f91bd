"""Records name the program that made them."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest
from benchmarks.provenance import UNKNOWN, commit_of, made_by, provenance
from benchmarks.report import processor_in


def git(folder: Path, *words: str) -> None:
    who = ["-c", "user.name=somebody", "-c", "user.email=somebody@example.org"]
    subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True)


def test_a_changed_working_copy_is_not_its_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", os.devnull)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    assert commit_of(tmp_path) == UNKNOWN
    (tmp_path / "file").write_text("as committed")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "page.md").write_text("as committed")
    for words in (["init"], ["add", "."], ["commit", "-m", "first"]):
        git(tmp_path, *words)
    commit = commit_of(tmp_path)
    assert re.fullmatch(r"[0-9a-f]{7,}", commit)
    (tmp_path / "docs" / "page.md").write_text("changed")
    assert commit_of(tmp_path) == commit
    (tmp_path / "file").write_text("changed")
    assert commit_of(tmp_path) == f"{commit}-dirty"


def test_all_makers_of_a_table_are_named_with_their_records() -> None:
    made = {"commit": "1a2b3c4", "date": "2026-11-26", "processor": "Fast 9000"}
    assert made_by([{"made": made}] * 3) == "By 1a2b3c4 on Fast 9000, 2026-11-26."
    assert made_by([{"made": made}] * 3 + [{}]) == (
        "3 by 1a2b3c4 on Fast 9000, 2026-11-26, 1 by an older program that did not record its commit."
    )
    assert made_by([]) == "No records."
    assert set(provenance()) == set(made)


def test_a_processor_name_without_a_number_gets_its_family() -> None:
    core = "processor\t: 0\ncpu family\t: 26\nmodel name\t: {}\nmodel\t\t: 2\n\n"
    assert processor_in(2 * core.format("AMD EPYC")) == "AMD EPYC family 26"
    assert processor_in(core.format("AMD EPYC 9654 96-Core")) == "AMD EPYC 9654 96-Core"
    assert processor_in("model name\t: Cortex\n") == "Cortex"
