"""Words that are not used here: .ci/words.txt against prose and names.

    python .ci/words.py            # fails where a folder has more than words_left.txt allows
    python .ci/words.py --list     # every place, as path:line: word (write instead)
    python .ci/words.py --write    # writes the present counts: after some were removed

Counts only shrink. A folder whose count reaches 0 leaves words_left.txt with the next `--write`
and is checked from then on without exception.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
WORDS, LEFT = HERE / "words.txt", HERE / "words_left.txt"
PLACES = (
    "*.md", "benchmarks/*.py", "docs", "examples", "experiments", "native", "ros2", "src", "tests",
)  # fmt: skip
"""What is checked, relative to the repository; "*.md" are the pages beside the README."""
SKIPPED = ("docs/development", "tests/release/test_words.py")
"""The laboratory notebook quotes its past, the test of this check its words."""
KINDS = {".cpp", ".hpp", ".md", ".py", ".xml", ".yaml"}


@dataclass(frozen=True)
class Use:
    """A word that is not used here, used.

    Attributes:
        path: Relative to the repository.
        line: From 1.
        word: As in words.txt.
    """

    path: str
    line: int
    word: str


def read_words(text: str) -> dict[str, str]:
    """Word to what to write instead, of the lines of words.txt."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return dict(line.split("\t") for line in lines)


def read_left(text: str) -> dict[str, int]:
    """Place to how many uses are allowed there, of the lines of words_left.txt."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return {place: int(count) for place, count in (line.split() for line in lines)}


def uses(text: str, words: Mapping[str, str]) -> Iterator[tuple[int, str]]:
    """Line numbers and words of a text; parts of a name such as told_frame count too."""
    listed = "|".join(re.escape(word) for word in sorted(words, key=len, reverse=True))
    pattern = re.compile(rf"(?<![^\W_])({listed})(?![^\W_])", re.IGNORECASE)
    for number, line in enumerate(text.splitlines(), 1):
        for found in pattern.finditer(line):
            yield number, found.group().lower()


def files_of(place: str, root: Path) -> list[Path]:
    """The files of a place that are checked, in order."""
    found = root.glob(place) if "*" in place else (root / place).rglob("*")
    kept = [path for path in found if path.suffix in KINDS and path.is_file()]
    skipped = [root / folder for folder in SKIPPED]
    return sorted(path for path in kept if not any(path.is_relative_to(one) for one in skipped))


def uses_in(place: str, root: Path, words: Mapping[str, str]) -> list[Use]:
    """All uses in a place."""
    return [
        Use(path.relative_to(root).as_posix(), line, word)
        for path in files_of(place, root)
        for line, word in uses(path.read_text(encoding="utf-8"), words)
    ]


def main(arguments: list[str] | None = None) -> int:
    """Check, list or write; 1 where a place has more uses than it may."""
    parser = argparse.ArgumentParser(description="Words that are not used here.")
    parser.add_argument("--list", action="store_true", help="every place")
    parser.add_argument("--write", action="store_true", help="write words_left.txt")
    asked = parser.parse_args(arguments)
    words = read_words(WORDS.read_text(encoding="utf-8"))
    found = {place: uses_in(place, ROOT, words) for place in PLACES}
    if asked.write:
        head = "# Uses of the words of words.txt that are left; made by: .ci/words.py --write\n"
        rows = [f"{place} {len(all_of)}\n" for place, all_of in found.items() if all_of]
        LEFT.write_text(head + "".join(rows), encoding="utf-8")
    allowed = read_left(LEFT.read_text(encoding="utf-8"))
    worse = [place for place in PLACES if len(found[place]) > allowed.get(place, 0)]
    for place in PLACES if asked.list else worse:
        for use in found[place]:
            print(f"{use.path}:{use.line}: {use.word} (write: {words[use.word]})")
    for place in PLACES:
        count, most = len(found[place]), allowed.get(place, 0)
        if count > most:
            print(f"{place}: {count} uses, {most} are allowed by .ci/words_left.txt")
        elif count < most:
            print(f"{place}: {count} uses, {most - count} fewer than allowed: run with --write")
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
