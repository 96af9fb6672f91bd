"""Records tell which program made them."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from benchmarks.provenance import UNKNOWN, commit_of, made_by, provenance


def git(folder: Path, *words: str) -> None:
    who = ["-c", "user.name=somebody", "-c", "user.email=somebody@example.org"]
    subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True)


def test_a_changed_working_copy_is_not_its_commit(tmp_path: Path) -> None:
    assert commit_of(tmp_path) == UNKNOWN
    (tmp_path / "file").write_text("as committed")
    for words in (["init"], ["add", "file"], ["commit", "-m", "first"]):
        git(tmp_path, *words)
    commit = commit_of(tmp_path)
    assert re.fullmatch(r"[0-9a-f]{7,}", commit)
    (tmp_path / "file").write_text("changed")
    assert commit_of(tmp_path) == f"{commit}-dirty"


def test_all_makers_of_a_table_are_named_with_their_records() -> None:
    made = {"commit": "1a2b3c4", "date": "2026-11-26", "processor": "Fast 9000"}
    assert made_by([{"made": made}] * 3) == "By 1a2b3c4 on Fast 9000."
    assert made_by([{"made": made}] * 3 + [{}]) == (
        "By 1a2b3c4 on Fast 9000: 3; an older program that did not tell its commit: 1."
    )
    assert set(provenance()) == set(made)
