from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from benchmarks.scan_answers import answers, write

from circumspect import Classifier, make_furniture


def snapshot(folder: Path, key: str, coverage: float) -> None:
    """A chair's complete surface in the place of a scan."""
    cloud = make_furniture("chair", 3).sampled(4_000, 0)
    points = cloud.points_xyz.astype(np.float32)
    rays = np.full((5, 3), 2.0, np.float32)
    np.savez_compressed(
        folder / f"{key.replace('/', '_')}.npz",
        points_end=points, areas_end=np.ones(len(points), np.float32), origins_end=rays,
        ends_end=-rays, coverage_end=np.array([coverage]), frame_end=np.array([7]),
    )  # fmt: skip


def test_a_classifier_is_asked_about_kept_scans(tmp_path: Path) -> None:
    snapshot(tmp_path, "furniture/chair-1", 1.0)
    found = [
        {
            "key": "furniture/chair-1",
            "suite": "furniture",
            "object": "chair",
            "true_label": "chair",
        },
        {"key": "furniture/bed-1", "suite": "furniture", "object": "bed", "true_label": None},
        {"key": "furniture/sofa-1", "suite": "furniture", "object": "sofa", "true_label": "sofa"},
    ]
    (row,) = answers(Classifier.load("robot", threads=1), found, tmp_path)
    assert (row["object"], row["place"], row["coverage"]) == ("chair", "end", 1.0)
    assert row["label"] == "chair"


def test_confident_answers_are_counted_and_those_of_them_that_are_wrong(tmp_path: Path) -> None:
    row = {
        "suite": "modelnet", "object": "bed_1", "place": "0.25", "coverage": 0.26,
        "true_label": "bed", "label": "bed", "probability": 0.9, "confident": True,
        "in_distribution": True,
    }  # fmt: skip
    rows = [row, {**row, "label": "sofa"}, {**row, "confident": False, "suite": "furniture"}]
    write({"robot": rows}, "COMMAND", tmp_path)
    lines = (tmp_path / "scan_answers.md").read_text().splitlines()
    assert "| robot | modelnet | 25 % | 2 | 0.500 | 2 | 1 |" in lines
    assert "| robot | furniture | 25 % | 1 | 1.000 | 0 | 0 |" in lines
    assert "| robot | all | 25 % | 3 | 0.667 | 2 | 1 |" in lines
    assert json.loads((tmp_path / "scan_answers.json").read_text())["answers"] == {"robot": rows}
