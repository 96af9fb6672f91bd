"""The docs name the boxes that are measured."""

from __future__ import annotations

from pathlib import Path

import pytest
from benchmarks.redkitchen_answers import BOXES, HEAD, replayed, row, words

DOCS = Path(__file__).resolve().parents[2] / "docs" / "real-frames.md"


@pytest.mark.parametrize("name", BOXES)
def test_the_page_names_the_same_box(name: str) -> None:
    command = " ".join(words(Path("redkitchen"), name, "given")).split(" --poses")[0]
    lines = [line.split() for line in DOCS.read_text(encoding="utf-8").splitlines()]
    assert f"{command} # the {name}".split() in lines


def test_a_row_shows_the_two_most_probable_classes() -> None:
    run = {
        "object": "table", "poses": "hidden", "confident": False, "frames": 250, "coverage": 0.5,
        "probabilities": {"bed": 0.1, "desk": 0.5, "table": 0.4}, "points": 12345,
        "outcomes": {"classified": 230, "no object in view": 20},
    }  # fmt: skip
    found = dict(zip(HEAD, row(run), strict=True))
    assert (found["answer"], found["next"]) == ("desk 50 %", "table 40 %")
    assert (found["frames"], found["coverage"], found["confident"]) == ("230 of 250", "50 %", "no")


def test_a_folder_without_frames_ends_with_the_error_of_replay(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        replayed(tmp_path, "chair", "given")
    assert ended.value.code == 2
    assert str(tmp_path) in capfd.readouterr().err
