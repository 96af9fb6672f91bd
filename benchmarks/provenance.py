"""Provenance of records: commit, date and processor."""

from __future__ import annotations

import subprocess
from collections import Counter
from collections.abc import Iterable
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.report import processor

UNKNOWN = "unknown"
NO_PROGRAM = (":(top,exclude)benchmarks/results", ":(top,exclude)docs")


@cache
def provenance() -> dict[str, str]:
    """Provenance of a record, which may be older than its table.

    It is computed once per process, because the code of a process does not change.

    Returns:
        "commit" of the repository that contains the benchmark, with "-dirty" if files differ from
        it; "date" (UTC); "processor".
    """
    return {
        "commit": commit_of(Path(__file__).parent),
        "date": datetime.now(UTC).date().isoformat(),
        "processor": processor(),
    }


def made_by(found: Iterable[dict[str, Any]]) -> str:
    """A sentence on the provenance of some records."""
    makers = Counter(_maker(record.get("made")) for record in found)
    if not makers:
        return "No records."
    if len(makers) == 1:
        return f"By {next(iter(makers))}."
    return ", ".join(f"{count} by {maker}" for maker, count in sorted(makers.items())) + "."


def commit_of(folder: Path) -> str:
    """Commit of the working copy that contains a folder; `UNKNOWN` without one."""
    try:
        commit = _git(folder, "rev-parse", "--short", "HEAD")
        # Results and documentation do not change what a benchmark measures.
        changed = _git(
            folder, "status", "--porcelain", "--untracked-files=no", "--", ":/", *NO_PROGRAM
        )
    except (OSError, subprocess.SubprocessError):
        return UNKNOWN
    return f"{commit}-dirty" if changed else commit


def _git(folder: Path, *words: str) -> str:
    done = subprocess.run(
        ["git", *words], cwd=folder, capture_output=True, text=True, check=True, timeout=10
    )
    return done.stdout.strip()


def _maker(made: dict[str, str] | None) -> str:
    if made is None:
        return "an older program that did not record its commit"
    return f"{made['commit']} on {made['processor']}, {made['date']}"
