"""The check of words that are not used here."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def checker() -> Iterator[ModuleType]:
    spec = importlib.util.spec_from_file_location("words", ROOT / ".ci" / "words.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["words"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["words"]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("It tells what it hears.", ["tells", "hears"]),
        ("def told_frame(self):", ["told"]),
        ("Lest it starts anew", ["lest", "anew"]),
        ("models, of which two", ["of which"]),
        ("the latest, untold and shears", []),
        ("heard2 and x_heard", ["heard"]),
    ],
)
def test_words_are_found_in_prose_and_in_names(
    checker: ModuleType, text: str, found: list[str]
) -> None:
    words = checker.read_words(checker.WORDS.read_text(encoding="utf-8"))
    assert [word for _, word in checker.uses(text, words)] == found


def test_each_word_has_a_replacement(checker: ModuleType) -> None:
    words = checker.read_words(checker.WORDS.read_text(encoding="utf-8"))
    assert len(words) > 5
    assert all(instead.strip() for instead in words.values())


def test_more_uses_than_allowed_fail(
    checker: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    (tmp_path / "docs" / "development").mkdir(parents=True)
    (tmp_path / "docs" / "page.md").write_text("It says so.\nNobody told it.\n")
    (tmp_path / "docs" / "development" / "past.md").write_text("It told.\n")
    monkeypatch.setattr(checker, "ROOT", tmp_path)
    monkeypatch.setattr(checker, "LEFT", tmp_path / "left.txt")
    checker.LEFT.write_text("docs 1\n")
    assert checker.main([]) == 0
    checker.LEFT.write_text("")
    assert checker.main([]) == 1
    assert "docs/page.md:2: told (write: " in capsys.readouterr().out
    assert checker.main(["--write"]) == 0
    assert checker.read_left(checker.LEFT.read_text()) == {"docs": 1}
