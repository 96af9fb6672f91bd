"""Programs beside the package explain themselves: `--help` starts no work of minutes."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = [
    file
    for folder in ("benchmarks", "docs")
    for file in sorted((ROOT / folder).glob("*.py"))
    if "__main__" in file.read_text(encoding="utf-8")
]


@pytest.mark.parametrize("file", PROGRAMS, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_it_reads_its_arguments_by_a_parser(file: Path) -> None:
    # Not run: what ignores --help would write over the results.
    text = file.read_text(encoding="utf-8")
    assert "ArgumentParser(description=__doc__)" in text
    assert "parse_args(" in text
    assert "sys.argv" not in text


def test_there_are_such_programs() -> None:
    assert {"run.py", "deletion.py", "dashboard.py"} <= {file.name for file in PROGRAMS}
