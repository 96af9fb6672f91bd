"""The trial of shard formats shows every grid once, and finds damage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from benchmarks import shard_formats
from benchmarks.shard_formats import FORMATS, measured


@pytest.fixture
def grids(monkeypatch: pytest.MonkeyPatch) -> np.ndarray:
    monkeypatch.setattr(shard_formats, "SHARD", 64)
    monkeypatch.setattr(shard_formats, "GROUP", 16)
    return np.random.default_rng(0).integers(0, 256, (150, 4096), dtype=np.uint8)


PARQUET = FORMATS[0]


def test_an_epoch_shows_every_grid_once_and_can_begin_anywhere(
    grids: np.ndarray, tmp_path: Path
) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    PARQUET.write(tmp_path, grids, np.zeros(150, np.int64))
    whole = np.concatenate(list(PARQUET.epoch(tmp_path, 3)))
    assert sorted(row.tobytes() for row in whole) == sorted(row.tobytes() for row in grids)
    assert not np.array_equal(whole, grids)
    later = np.concatenate(list(PARQUET.epoch(tmp_path, 3, 97)))
    np.testing.assert_array_equal(later, whole[97:])


def test_parquet_reports_all_damage(grids: np.ndarray, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    found = measured(PARQUET, tmp_path, grids, np.zeros(150, np.int64))
    assert not any("silent" in found[what] for what in ("truncated", "flipped", "lost"))
