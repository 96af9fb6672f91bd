"""Sets become shards: whole, once, resumable, and refused where something does not fit."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from here_pool import HerePool
from two_kinds import renamed, two_kinds

from circumspect.classification import GridSpec
from circumspect.cli.main import main
from circumspect.datasets import Augmentation, ObjectSet
from circumspect.datasets.gathered_set import GatheredScan, write_cloud
from circumspect.datasets.point_pack import write_point_pack
from circumspect.datasets.shard_file import Rows
from circumspect.datasets.sharded_set import ShardedSet
from circumspect.errors import InputError, OutputError
from circumspect.gathering import LocalPool, conversion
from circumspect.gathering.conversion import ConversionSettings, convert, converted
from circumspect.geometry import PointCloud

pytest.importorskip("pyarrow", reason="pyarrow is not installed")
INPUT_SPEC = GridSpec(azimuth_views=2)
SETTINGS = ConversionSettings(INPUT_SPEC, Augmentation(), replicas=3, shard_size=20)


@pytest.fixture
def data(monkeypatch: pytest.MonkeyPatch) -> dict[str, ObjectSet]:
    sets = {
        "train": two_kinds(24, seed=1),
        "validation": renamed(two_kinds(6, seed=2), "held"),
        "test": renamed(two_kinds(10, seed=3), "test"),
    }
    monkeypatch.setattr(conversion, "_objects_of", lambda _: sets)
    return sets


def read(folder: Path, split: str) -> tuple[Rows, np.ndarray]:
    with ShardedSet.read(folder, split) as shards:
        rows = Rows.joined(list(shards.in_order()))
        return rows, shards.unpacked(rows)


def test_all_objects_are_there_with_their_variants(data: dict, tmp_path: Path) -> None:
    shown: list[tuple[int, int]] = []
    counts = convert(
        tmp_path, str(tmp_path), SETTINGS, HerePool(), lambda *what: shown.append(what)
    )
    assert counts == {"train": 72, "validation": 6, "test": 10, "left out": 0}
    assert shown == [(done, 6) for done in range(7)]
    train, grids = read(tmp_path, "train")
    assert grids.shape == (72, 1, *INPUT_SPEC.shape)
    assert set(train.objects.tolist()) == set(data["train"].names.tolist())
    assert len(np.unique(train.packed, axis=0)) == 72, "variants differ"
    assert len(list((tmp_path / "train").iterdir())) == 4
    neighbours = train.objects[1:] == train.objects[:-1]
    assert neighbours.mean() < 0.3, "variants of an object do not lie together"
    tests, views = read(tmp_path, "test")
    assert views.shape == (10, 2, *INPUT_SPEC.shape)
    for name, label, grid in zip(tests.objects, tests.labels, views, strict=True):
        index = data["test"].names.tolist().index(name)
        assert data["test"].labels[index] == label
        expected = INPUT_SPEC.grids(data["test"].cloud(index), [0.0])[0]
        np.testing.assert_array_equal(grid, expected)


def test_the_same_command_makes_missing_and_broken_shards(data: dict, tmp_path: Path) -> None:
    convert(tmp_path, str(tmp_path), SETTINGS, HerePool())
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.parquet")}
    lost, cut = sorted((tmp_path / "train").iterdir())[1:3]
    lost.unlink()
    cut.write_bytes(cut.read_bytes()[:100])
    pool = HerePool()
    convert(tmp_path, str(tmp_path), SETTINGS, pool)
    assert pool.done == [f"train/{lost.name}", f"train/{cut.name}"]
    assert {path: path.read_bytes() for path in tmp_path.rglob("*.parquet")} == before


@pytest.mark.parametrize(
    "other",
    [
        replace(SETTINGS, seed=1), replace(SETTINGS, replicas=2),
        replace(SETTINGS, input_spec=replace(INPUT_SPEC, shape=(8, 16, 8))),
        replace(SETTINGS, augmentation=Augmentation(stretch=0.2)),
        replace(SETTINGS, shard_size=30),
    ],
)  # fmt: skip
def test_shards_of_another_set_are_not_mixed(
    other: ConversionSettings, data: dict, tmp_path: Path
) -> None:
    convert(tmp_path, str(tmp_path), SETTINGS, HerePool())
    pool = HerePool()
    with pytest.raises(InputError, match=r"\.parquet: is of another set"):
        convert(tmp_path, str(tmp_path), other, pool)
    assert not pool.done


def test_an_object_of_two_splits_is_named(data: dict, tmp_path: Path) -> None:
    data["test"] = replace(data["test"], names=data["train"].names[:10])
    with pytest.raises(InputError, match="plate_0000 is in the train and in the test split"):
        convert(tmp_path, str(tmp_path), SETTINGS, HerePool())
    assert not list(tmp_path.iterdir())


def test_objects_without_a_shape_are_left_out_of_tests(data: dict, tmp_path: Path) -> None:
    points = data["test"].points_xyz.copy()
    points[4] = 0.0
    data["test"] = replace(data["test"], points_xyz=points)
    counts = convert(tmp_path, str(tmp_path), SETTINGS, HerePool())
    assert (counts["test"], counts["left out"]) == (9, 1)


def test_a_shard_that_fails_is_reported_and_the_others_are_made(
    data: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Failing(HerePool):
        def outcomes(self, jobs: Any, work: Any) -> Iterator[tuple[Any, Any]]:
            for number, job in enumerate(jobs):
                yield job, OSError("disk full") if number == 1 else work(job)

    with pytest.raises(OutputError, match=r"1 shards failed, the first: train/00001-of-00004"):
        convert(tmp_path, str(tmp_path), SETTINGS, Failing())
    assert len(list(tmp_path.rglob("*.parquet"))) == 5


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"replicas": 0}, "0 variants"),
        ({"shard_size": 2}, "holds all variants"),
        ({"input_spec": GridSpec(visibility=True)}, "hold grids of occupancy"),
    ],
)
def test_invalid_settings_are_refused(changed: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(SETTINGS, **changed)


def test_shards_may_lie_in_an_object_store(data: dict, tmp_path: Path) -> None:
    assert convert(tmp_path, "memory://converted", SETTINGS, HerePool())["train"] == 72
    with ShardedSet.read("memory://converted", "train") as shards:
        assert len(shards) == 72


def test_the_command_converts_a_set(
    data_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    out = str(tmp_path / "shards")
    flags = [str(data_set), "--out", out, "--replicas", "2", "--workers", "1", "--json"]
    assert main(["data", "convert", *flags]) == 0
    counts = json.loads(capsys.readouterr().out)
    with ShardedSet.read(out, "train") as shards:
        assert len(shards) == counts["train"]
    assert counts["train"] + 2 * counts["validation"] == 2 * 24
    assert counts["test"] == 10
    assert main(["data", "verify", str(data_set), "--replicas", "2"]) == 2
    assert "--replicas belongs to data convert" in capsys.readouterr().err
    assert main(["data", "convert", str(data_set), "--net", "pointnet", "--out", out]) == 2
    assert "pointnet takes points" in capsys.readouterr().err


@pytest.fixture
def data_set(tmp_path: Path) -> Path:
    folder = tmp_path / "set"
    folder.mkdir()
    for split, objects in (("train", two_kinds(24, seed=1)), ("test", two_kinds(10, seed=3))):
        write_point_pack(folder / f"{split}.npz", renamed(objects, split))
    return folder


def test_shards_of_a_gathered_set_record_the_starts_of_scans(tmp_path: Path) -> None:
    folder, points = tmp_path / "set", two_kinds(2).points_xyz
    (folder / "clouds").mkdir(parents=True)
    lines = []
    for number in range(12):
        label, split = ("plate", "post")[number % 2], "test" if number > 9 else "train"
        for start in (0.0, 45.0) if split == "test" else (0.0,):
            name = f"thing{number}@{start:03.0f}"
            cloud = PointCloud(points[number % 2] * (1 + number / 20))
            write_cloud(folder / "clouds" / f"{name}.npz", cloud)
            files = {"cloud": f"clouds/{name}.npz"}
            lines.append(GatheredScan(name, f"thing{number}", label, split, start, files).line())
    (folder / "manifest.jsonl").write_text("".join(lines))
    convert(folder, str(tmp_path / "shards"), SETTINGS, HerePool())
    rows, _ = read(tmp_path / "shards", "test")
    found = sorted(zip(rows.objects.tolist(), rows.starts_deg.tolist(), strict=True))
    assert found == [("thing10", 0.0), ("thing10", 45.0), ("thing11", 0.0), ("thing11", 45.0)]


def test_processes_make_the_same_shards(data_set: Path, tmp_path: Path) -> None:
    """The work can be sent to another process, and gives the same there."""
    pool = HerePool()
    convert(data_set, str(tmp_path / "here"), SETTINGS, pool)
    convert(data_set, str(tmp_path / "away"), SETTINGS, LocalPool(1))
    for name in pool.done:
        assert (tmp_path / "here" / name).read_bytes() == (tmp_path / "away" / name).read_bytes()
    assert converted.__module__ == "circumspect.gathering.conversion"
