"""The comparison of dithered grids and others."""

import json

import numpy as np
import pytest
from benchmarks import cell_borders
from benchmarks.cell_borders import main, measured


def test_spread_and_labels_are_counted_by_piece():
    scores = np.zeros((2, 3, 2))
    scores[:, :, 0] = [[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]]
    row = measured(4, True, 2 * scores[:1], scores)
    assert row["other_label"] == 0.5
    assert row["turned_spread"] == 0
    assert row["spread"] == pytest.approx(np.std([1.0, -1.0, 1.0], ddof=1) / 4)


def test_the_page_is_written(monkeypatch, tmp_path):
    monkeypatch.setattr("sys.argv", ["cell_borders", "--out", str(tmp_path)])
    for name, value in (("EACH", 1), ("TIMES", 2), ("CATEGORIES", ("night_stand", "table"))):
        monkeypatch.setattr(cell_borders, name, value)
    monkeypatch.setattr(cell_borders, "SCHEMES", ((1, False), (4, True)))
    assert main() == 0
    rows = json.loads((tmp_path / "cell_borders.json").read_text())["schemes"]
    assert [(row["views"], row["dithered"]) for row in rows] == [(1, False), (4, True)]
    assert all(row["spread"] > 0 and row["turned_spread"] > 0 for row in rows)
    assert "| 4 | yes |" in (tmp_path / "cell_borders.md").read_text()
