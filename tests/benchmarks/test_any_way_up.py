"""How the bound of `--up auto` is chosen and reported."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from benchmarks.any_way_up import (
    FLOOR,
    TURNED,
    UPRIGHT,
    choice_text,
    chosen,
    main,
    quarter_turn,
    with_floor,
)
from scipy.spatial.transform import Rotation

from circumspect.classification.upright import stood
from circumspect.datasets import furniture_set
from circumspect.datasets.point_pack import write_point_pack
from circumspect.furniture import make_furniture
from circumspect.geometry import cut_floor


def rows(close: float, upright: float, turned: float) -> list[dict]:
    shares = {"confident": 0.5, "confident_correct": 0.4}
    correct = {UPRIGHT: upright, TURNED: turned, FLOOR: 0.0}
    return [{"close": close, "case": case, "correct": c, **shares} for case, c in correct.items()]


def test_the_bound_with_most_correct_labels_is_chosen() -> None:
    found = [*rows(0.5, 0.9, 0.5), *rows(0.8, 0.8, 0.7), *rows(1.0, 0.7, 0.8)]
    assert chosen(found) == 1.0, "of equals the larger"
    assert chosen([*found, *rows(0.9, 0.8, 0.71)]) == 0.9
    text = choice_text(100, found)
    assert "**1**" in text
    assert "| 0.8 | 80.0% | 70.0% | 75.0% | 50.0% | 80.0% | 10.0% |" in text


@pytest.mark.parametrize("seed", range(12))
def test_a_turned_object_never_stands_upright(seed: int) -> None:
    up = quarter_turn(np.random.default_rng(seed)).apply([0.0, 0.0, 1.0])
    assert up[2] < 1e-9
    assert np.sort(np.abs(up)) == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)


def test_the_floor_can_be_found_and_cut() -> None:
    rng = np.random.default_rng(0)
    scan = with_floor(make_furniture("chair", 3).sampled(1024, 0), rng)
    assert len(scan) == 2048
    turn = Rotation.from_euler("y", 90, degrees=True)
    cut = cut_floor(stood(scan, turn), any_way_up=True)
    assert cut is not None
    assert cut.plane.normal_xyz == pytest.approx(turn.apply([0.0, 0.0, 1.0]), abs=0.02)


def test_the_report_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_point_pack(tmp_path / "test.npz", furniture_set(1, first_seed=3_000_000))
    words = ["any_way_up", str(tmp_path), "--split", "test", "--out", str(tmp_path)]
    monkeypatch.setattr("sys.argv", words)
    assert main() == 0
    found = {
        row["case"]: row for row in json.loads((tmp_path / "any_way_up.json").read_text())["rows"]
    }
    assert list(found) == [UPRIGHT, TURNED, FLOOR]
    assert found[UPRIGHT]["correct_as_it_lies"] >= 0.7
    assert found[TURNED]["correct"] > found[TURNED]["correct_as_it_lies"]
    assert found[FLOOR]["confident"] <= 0.2
    assert (tmp_path / "any_way_up.md").read_text().count("\n| ") == 5
