"""The table of the shipped classifier's answers to few points."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from benchmarks.few_points import COUNTS, main, measured

from circumspect.classification import Prediction
from circumspect.datasets import furniture_set
from circumspect.datasets.point_pack import write_point_pack


def test_shares_are_of_the_answers_that_they_name() -> None:
    test = furniture_set(1)
    correct = [Prediction(test.classes[label], 0.9, {}, distance=0.01) for label in test.labels]
    wrong = Prediction(correct[1].label, 0.9, {}, in_distribution=False, distance=0.01)
    far = Prediction(correct[1].label, 0.9, {}, in_distribution=False, distance=0.5)
    answers = [wrong, far, *correct[2:]]
    row = measured(64, answers, test, 0.1)
    count = len(test)
    assert row["accuracy"] == pytest.approx((count - 1) / count)
    assert row["near"] == pytest.approx((count - 1) / count)
    assert row["incorrect_of_near"] == pytest.approx(1 / (count - 1))
    assert row["in_distribution"] == pytest.approx((count - 2) / count)


def test_the_page_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_point_pack(tmp_path / "test.npz", furniture_set(1))
    monkeypatch.setattr("sys.argv", ["few_points", str(tmp_path), "--out", str(tmp_path)])
    assert main() == 0
    rows = json.loads((tmp_path / "few_points.json").read_text())["counts"]
    assert [row["points"] for row in rows] == list(COUNTS)
    assert all(row["in_distribution"] == 0 for row in rows if row["points"] < 128)
    assert rows[-1]["in_distribution"] > 0
    assert rows[-1]["accuracy"] > rows[0]["accuracy"]
    assert (tmp_path / "few_points.md").read_text().count("%") >= 4 * len(COUNTS)
