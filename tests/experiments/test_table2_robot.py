"""The half of Table 2 on scans, from a small gathered set with several starts."""

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

from circumspect.classification import Classifier
from circumspect.datasets import GridCache
from circumspect.datasets.gathered_set import MANIFEST, GatheredScan, write_cloud
from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect_experiments import RobotScans, Table2, reproduce_robot
from circumspect_experiments.robot_answers import StartAnswers, robot_answers
from circumspect_experiments.table2_robot import EPOCH_DRAWS, with_equal_steps
from circumspect_experiments.whole_set import ROBOT

QUICK = Table2(epochs=1, shape=(14, 14, 14))
STARTS = (0.0, 22.5, 45.0, 90.0, 135.0)


@pytest.fixture(scope="module")
def gathered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("gathered")
    (folder / "grids").mkdir()
    input_spec, lines = Classifier.load("robot").input_spec, []
    for split, objects in (("train", two_kinds(6)), ("test", two_kinds(4, seed=1))):
        for number in range(len(objects)):
            label = objects.classes[objects.labels[number]]
            for start in STARTS:
                turned = Rotation.from_euler("z", -start, degrees=True)
                name = f"{label}-{split}{number}@{start:g}"
                cloud = PointCloud(turned.apply(objects.points_xyz[number]))
                write_cloud(folder / f"clouds/{name}.npz", cloud)
                input_spec.bounds(cloud).hits(cloud.points_xyz).save(folder / f"grids/{name}.npz")
                scan = GatheredScan(
                    name, f"{label}-{split}{number}", label, split, start,
                    {"cloud": f"clouds/{name}.npz", "grid": f"grids/{name}.npz"},
                )  # fmt: skip
                lines.append(scan.line())
    (folder / MANIFEST).write_text("".join(lines))
    return folder


def test_every_network_is_tested_on_scans_from_every_start(
    gathered: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("circumspect_experiments.table2_robot.EPOCH_DRAWS", 12)
    out, cache = tmp_path / "out", GridCache(tmp_path / "grids")
    watched = Watched()
    scans = RobotScans.read(gathered)
    document = reproduce_robot(scans, QUICK, out, watched, cache)
    assert json.loads((out / "table2_robot.json").read_text()) == json.loads(json.dumps(document))
    assert document["test_scans"] == {f"{start:g}": 4 for start in STARTS}
    assert document["train_scans"] == 6, "one scan an object, from the first start"
    assert [row["network"] for row in document["rows"]] == [
        *(f"{grid}, {pool}" for grid, pool in ROBOT), "ours (planes)", "robot"
    ]  # fmt: skip
    publications = [*ROBOT.values(), None, None]
    for row, published in zip(document["rows"], publications, strict=True):
        assert row["paper"] == (None if published is None else list(published))
        assert set(row["accuracy"]) == {f"{start:g}" for start in STARTS}
        assert row["worst"] <= row["mean"]
        seeds = 3 if row["network"] in ("cylindrical, rwmp", "ours (planes)") else 1
        assert len(row["seeds"]) == seeds
        for start, accuracy in row["accuracy"].items():
            assert accuracy == np.mean([seed["accuracy"][start] for seed in row["seeds"]])
    assert document["rows"][-1]["left_out"] == 0
    # It knows neither plates nor posts.
    assert document["rows"][-1]["mean"] == 0
    text = (out / "table2_robot.md").read_text()
    assert "(0.89)" in text
    assert "| 22.5°" in text
    assert "| cylindrical, rwmp, seed 2 |" in text
    assert "±" in text
    for name in ("cylindrical_rwmp", "robot"):
        assert np.ptp(imread(out / f"confusion_robot_{name}.png")[..., :3]) > 0.5
    again = Watched()
    assert reproduce_robot(scans, QUICK, out, again, cache) == document


def test_an_epoch_shows_as_many_scans_as_one_on_modelnet10_shows_objects() -> None:
    defaults = QUICK.settings("moon2018")
    assert with_equal_steps(defaults, 360) == replace(defaults, passes=9)
    assert with_equal_steps(defaults, 10 * EPOCH_DRAWS) == defaults


def test_labels_change_where_an_object_is_not_called_the_same() -> None:
    answers = {0.0: [0, 1, 1], 45.0: [0, 2], 90.0: [0, 1]}
    objects = {0.0: ["a", "b", "c"], 45.0: ["a", "b"], 90.0: ["a", "c"]}
    found = StartAnswers(
        {start: np.zeros(len(some), int) for start, some in answers.items()},
        {start: np.array(some) for start, some in answers.items()},
        {start: np.array(some) for start, some in objects.items()},
        ("plate", "post"),
    )
    assert found.changes == 0, "b and c were not scanned from all starts"
    assert found.accuracy == {0.0: pytest.approx(1 / 3), 45.0: 0.5, 90.0: 0.5}
    np.testing.assert_array_equal(found.confusion([0.0, 45.0]), [[2, 2, 1], [0, 0, 0], [0, 0, 0]])
    two = replace(found, answers={**found.answers, 90.0: np.array([1, 1])})
    assert two.changes == 1
    assert two.to_dict()["worst"] == 0


def test_scans_of_objects_that_trained_the_robots_classifier_are_left_out(
    gathered: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scans = RobotScans.read(gathered)
    fitted = scans.tests[0.0].shown[0]
    classifier = Classifier.load("robot")
    monkeypatch.setattr(type(classifier), "training", {"objects": [str(fitted)]})
    answers, left_out = robot_answers(scans)
    assert left_out == len(STARTS)
    assert all(fitted not in objects for objects in answers.objects.values())


@pytest.mark.parametrize(
    ("left_out", "why"),
    [
        ("@45", "holds no test scans from 45°"),
        ("-test", "holds no test scans from 0°, 45°, 90°, 135°"),
        ("-train", "holds no scan of the train split"),
        ("plate-train", "no training object of class plate"),
        ("-train[1-9]", "no object falls into the validation split|no training object"),
    ],
)
def test_an_unsuitable_set_is_refused(
    gathered: Path, tmp_path: Path, left_out: str, why: str
) -> None:
    (tmp_path / "clouds").symlink_to(gathered / "clouds")
    lines = (gathered / MANIFEST).read_text().splitlines(keepends=True)
    kept = [line for line in lines if not re.search(left_out, json.loads(line)["scan"])]
    (tmp_path / MANIFEST).write_text("".join(kept))
    with pytest.raises(InputError, match=why) as refused:
        RobotScans.read(tmp_path)
    assert str(refused.value).startswith(str(tmp_path))
