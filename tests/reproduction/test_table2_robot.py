"""The table's half on scans, from a small set that lies as robots with other starts have it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from experiment_watcher import Watched
from matplotlib.image import imread
from scipy.spatial.transform import Rotation
from two_kinds import two_kinds

from circumspect.datasets import GridCache
from circumspect.datasets.gathered_set import MANIFEST, GatheredScan, write_cloud
from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.reproduction import RobotScans, Table2, reproduce_robot
from circumspect.reproduction.published import ROBOT
from circumspect.reproduction.table2_robot import MORE_EPOCHS, for_few

QUICK = Table2(epochs=1, shape=(14, 14, 14))
STARTS = (0.0, 22.5, 45.0, 90.0, 135.0)


@pytest.fixture(scope="module")
def gathered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("gathered")
    lines = []
    for split, objects in (("train", two_kinds(6)), ("test", two_kinds(4, seed=1))):
        for number in range(len(objects)):
            label = objects.classes[objects.labels[number]]
            for start in STARTS:
                turned = Rotation.from_euler("z", -start, degrees=True)
                name = f"{label}-{split}{number}@{start:g}"
                write_cloud(
                    folder / f"clouds/{name}.npz",
                    PointCloud(turned.apply(objects.points_xyz[number])),
                )
                scan = GatheredScan(
                    name, f"{label}-{split}{number}", label, split, start,
                    {"cloud": f"clouds/{name}.npz"},
                )  # fmt: skip
                lines.append(scan.line())
    (folder / MANIFEST).write_text("".join(lines))
    return folder


def test_every_network_is_tested_on_scans_from_every_start(gathered: Path, tmp_path: Path) -> None:
    out, cache = tmp_path / "out", GridCache(tmp_path / "grids")
    watched = Watched()
    scans = RobotScans.read(gathered)
    document = reproduce_robot(scans, QUICK, out, watched, cache)
    assert json.loads((out / "table2_robot.json").read_text()) == json.loads(json.dumps(document))
    assert document["test_scans"] == {f"{start:g}": 4 for start in STARTS}
    assert document["train_scans"] == 6, "one scan an object, from the first start"
    assert [row["network"] for row in document["rows"]] == [
        *(f"{grid}, {pool}" for grid, pool in ROBOT), "ours (planes)"
    ]  # fmt: skip
    for row, published in zip(document["rows"], [*ROBOT.values(), None], strict=True):
        assert row["paper"] == (None if published is None else list(published))
        assert set(row["accuracy"]) == {f"{start:g}" for start in STARTS}
        assert row["worst"] == min(row["accuracy"].values())
    text = (out / "table2_robot.md").read_text()
    assert "(0.89)" in text
    assert "| 22.5°" in text
    assert np.ptp(imread(out / "confusion_robot_cylindrical_rwmp.png")[..., :3]) > 0.5
    again = Watched()
    assert reproduce_robot(scans, QUICK, out, again, cache) == document


def test_few_scans_are_shown_more_often_and_in_small_batches() -> None:
    meant = QUICK.settings("moon2018")
    few = for_few(meant)
    assert few.epochs == MORE_EPOCHS * meant.epochs
    assert few.learning_rate / few.batch_size == meant.learning_rate / meant.batch_size
    assert replace(few, epochs=1, batch_size=32, learning_rate=meant.learning_rate) == meant


@pytest.mark.parametrize(
    ("left_out", "why"),
    [
        ("@45", "holds no scans from 45°"),
        ("-test", "holds no scan of the test split"),
        ("-train", "holds no scan of the train split"),
        ("plate-train", "no training object of class plate"),
        ("-train[1-9]", "no object falls into the validation split|no training object"),
    ],
)
def test_a_set_that_will_not_do_is_refused(
    gathered: Path, tmp_path: Path, left_out: str, why: str
) -> None:
    (tmp_path / "clouds").symlink_to(gathered / "clouds")
    lines = (gathered / MANIFEST).read_text().splitlines(keepends=True)
    kept = [line for line in lines if not re.search(left_out, json.loads(line)["scan"])]
    (tmp_path / MANIFEST).write_text("".join(kept))
    with pytest.raises(InputError, match=why) as refused:
        RobotScans.read(tmp_path)
    assert str(refused.value).startswith(str(tmp_path))
