"""The fuzzer on each target, shortly; before a release it runs long."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.fuzz.fuzzer import fuzz
from tests.fuzz.mutations import mutated
from tests.fuzz.targets import TARGETS, Target


# Of the first seed's inputs; the readers of shapes and arrays have tests of their own kind.
@pytest.mark.parametrize("name", [name for name in TARGETS if name != "networks"])
def test_mutated_files_are_known_faults_at_most(name: str, tmp_path: Path) -> None:
    found = fuzz(TARGETS[name], tmp_path / name, seconds=2.0, seed=1, most=60)
    assert found.clean, f"{dict(found.faults)}; python -m tests.fuzz {name} --seed 1"
    assert found.inputs >= 1


def test_mutations_repeat_with_their_seed() -> None:
    content = bytes(range(200))
    first = [mutated(content, b"other", random.Random(seed)) for seed in range(50)]
    assert first == [mutated(content, b"other", random.Random(seed)) for seed in range(50)]
    assert len(set(first)) > 40


def test_a_fault_is_found_and_kept(tmp_path: Path) -> None:
    def read(path: Path) -> None:
        if path.read_bytes()[:1] != b"a":
            raise KeyError("not an a")

    def seeds(folder: Path) -> list[Path]:
        (folder / "a.txt").write_bytes(b"a")
        return [folder / "a.txt"]

    found = fuzz(Target(seeds, read), tmp_path / "out", seconds=5.0, seed=0, most=100)
    assert not found.clean
    ((place, file),) = found.kept.items()
    assert place.startswith("KeyError at test_fuzz.py")
    assert file.read_bytes()[:1] != b"a"
