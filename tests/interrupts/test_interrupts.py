"""Ctrl-C at a few moments of a few commands; `python -m tests.interrupts` does it at length."""

from __future__ import annotations

import json
import sys
import zipfile
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.interrupts.harness import Ended, cut, faults, run
from tiny_commands import TinyInputs


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> TinyInputs:
    return TinyInputs(tmp_path_factory.mktemp("inputs"))


@pytest.mark.parametrize("name", ["classify", "grid", "data import"])
def test_ctrl_c_leaves_one_line_and_no_half_file(
    name: str, inputs: TinyInputs, tmp_path: Path
) -> None:
    command = tuple(name.split())
    whole = run(inputs.words(command, tmp_path / "whole"), longest=120)
    assert whole.code == 0, whole.err
    for share in (0.15, 0.5, 0.8):
        out = tmp_path / f"after {share}"
        ended = run(inputs.words(command, out), share * whole.seconds, longest=120)
        assert faults(ended, out, whole.code) == [], ended.err
        assert ended.err.count("\n") <= 1


def test_half_files_are_found(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(json.dumps({"a": 1})[:-1])
    (tmp_path / "b.jsonl").write_text('{"a": 1}\n{"a"')
    with zipfile.ZipFile(tmp_path / "c.npz", "w") as archive:
        archive.writestr("a", "a" * 1000)
    content = (tmp_path / "c.npz").read_bytes()
    (tmp_path / "c.npz").write_bytes(content[:-100])
    (tmp_path / ".d-partial-0.png").touch()
    (tmp_path / "whole.json").write_text("{}")
    found = faults(Ended(0, "", "", 1.0), tmp_path, 0)
    assert [line.split(":")[0] for line in found] == [
        ".d-partial-0.png",
        "a.json",
        "b.jsonl",
        "c.npz",
    ]
    assert cut(tmp_path / "whole.json") is None


def test_wrong_ends_are_found(tmp_path: Path) -> None:
    assert faults(Ended(130, "", "circumspect: interrupted\n", 1.0), tmp_path, 0) == []
    assert faults(Ended(0, "", "", 1.0), tmp_path, 0) == []
    assert len(faults(Ended(1, "", "Traceback (most recent call last)", 1.0), tmp_path, 0)) == 2
    assert len(faults(Ended(130, "", "", 60.0), tmp_path, 0)) == 2
