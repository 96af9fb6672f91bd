"""Which program made a record, when and on what."""

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
    """What goes into a record that takes long to make, as it may be older than its table.

    It is looked up once a process, whose code stays what it was.

    Returns:
        "commit" of the repository that the benchmark is in, with "-dirty" where files differ from
        it; "date" (UTC); "processor".
    """
    return {
        "commit": commit_of(Path(__file__).parent),
        "date": datetime.now(UTC).date().isoformat(),
        "processor": processor(),
    }


def made_by(found: Iterable[dict[str, Any]]) -> str:
    """A sentence about who made some records."""
    makers = Counter(_maker(record.get("made")) for record in found)
    if not makers:
        return "No records."
    if len(makers) == 1:
        return f"By {next(iter(makers))}."
    return ", ".join(f"{count} by {maker}" for maker, count in sorted(makers.items())) + "."


def commit_of(folder: Path) -> str:
    """The working copy that a folder is in; `UNKNOWN` where it is in none."""
    try:
        commit = _git(folder, "rev-parse", "--short", "HEAD")
        # What a benchmark writes and prints does not change what it measures.
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
