"""Test objects are found among the training objects at any yaw."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from circumspect.datasets import ObjectSet, furniture_set
from circumspect.datasets.point_pack import write_point_pack

ROOT = Path(__file__).resolve().parents[2]


def test_turned_objects_are_their_own_nearest(tmp_path: Path) -> None:
    train = furniture_set(1)
    turn = Rotation.from_euler("z", 45, degrees=True).as_matrix().astype(np.float32)
    names = np.array([f"{name}_turned" for name in train.names])
    test = ObjectSet(train.points_xyz @ turn.T, train.labels, names, train.classes)
    write_point_pack(tmp_path / "train.npz", train)
    write_point_pack(tmp_path / "test.npz", test)
    words = [sys.executable, "-m", "benchmarks.lookalikes", str(tmp_path), "--out", str(tmp_path)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "lookalikes.json").read_text())
    assert found["nearest_is_right"] == 1.0
    assert found["right"]["objects"] + found["wrong"]["objects"] == len(test)
    assert found["right"]["true class"] == 1.0
    assert "| right |" in (tmp_path / "lookalikes.md").read_text()
