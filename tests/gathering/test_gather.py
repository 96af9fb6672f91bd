"""Gathered sets: made, resumed, grown, read, checked."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import signal
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets import open_data_set
from circumspect.datasets.gathered_set import (
    ASKED,
    MANIFEST,
    GatheredScan,
    read_gathered,
    read_manifest,
    read_points,
    write_cloud,
)
from circumspect.datasets.gathered_verification import verify_gathered
from circumspect.errors import InputError, MissingExtraError, OutputError
from circumspect.gathering import GatherSettings, LocalPool, objects_for
from circumspect.gathering.contact_sheet import draw_contact_sheet, drawn, shown_scans
from circumspect.gathering.gather import gather
from circumspect.gathering.recorded_scan import RecordedObject
from circumspect.gathering.set_place import SetFolder
from circumspect.geometry import PointCloud

QUICK = GatherSettings(("chair", "bed"), 1, 0, (0.0, 90.0), frame_interval=2.0, frames=3)


def make(folder: Path, settings: GatherSettings = QUICK, **more: Any) -> list[GatheredScan]:
    return gather(SetFolder(folder), settings, objects_for(settings), LocalPool(1), **more)


@pytest.fixture(scope="module")
def gathered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("gathered") / "set"
    reported: list[tuple[int, int, str]] = []
    make(folder, progress=lambda *what: reported.append(what))
    assert reported[0] == (0, 4, "")
    assert reported[-1][:2] == (4, 4)
    return folder


def copied(gathered: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(gathered, tmp_path / "copy"))


def test_a_set_holds_each_object_from_each_start(gathered: Path) -> None:
    scans = read_manifest(gathered)
    assert [(s.label, s.start_deg) for s in scans] == [
        ("chair", 0.0), ("bed", 0.0), ("chair", 90.0), ("bed", 90.0)
    ]  # fmt: skip
    for scan in scans:
        assert set(scan.files) == {"cloud", "grid", "poses", "odometry"}
        assert all((gathered / name).is_file() for name in scan.files.values())
        assert scan.quality["frames"] == 3
        assert scan.split == "train"
    assert len({scan.quality["seed"] for scan in scans}) == 4
    assert verify_gathered(gathered).complete


def test_existing_scans_are_kept_while_the_set_grows(
    gathered: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = copied(gathered, tmp_path)
    asked: list[str] = []
    monkeypatch.setattr(
        LocalPool,
        "outcomes",
        lambda pool, jobs, work: asked.extend(job.key for job in jobs) or iter(()),
    )
    make(folder)
    assert asked == []
    assert verify_gathered(folder).complete
    make(folder, replace(QUICK, classes=("chair", "sofa"), train_starts_deg=(0.0, 22.5)))
    assert asked == ["sofa-200000@000", "chair-200000@022.5", "sofa-200000@022.5"]
    found = verify_gathered(folder)
    assert not found.complete
    assert found.missing == (
        "chair-200000 from 22.5°",
        "sofa-200000 from 0°",
        "sofa-200000 from 22.5°",
    )


def test_an_empty_set_is_not_complete(tmp_path: Path) -> None:
    SetFolder(tmp_path / "set").begin({"source": "recordings"})
    assert not verify_gathered(tmp_path / "set").complete


def test_a_set_that_was_killed_at_its_beginning_resumes(tmp_path: Path) -> None:
    SetFolder(tmp_path).begin({"source": "recordings"})
    (tmp_path / MANIFEST).unlink()
    SetFolder(tmp_path).begin({"source": "recordings"})
    assert read_manifest(tmp_path) == []
    (tmp_path / MANIFEST).unlink()
    (tmp_path / "settings.json").write_text('{"editor.fontSize": 12}')
    with pytest.raises(InputError, match="holds something else"):
        SetFolder(tmp_path).begin({"source": "recordings"})


def test_a_scan_is_added_behind_a_line_that_was_cut(tmp_path: Path) -> None:
    (tmp_path / MANIFEST).write_text(scan().line() + scan("cut").line()[:30])
    SetFolder(tmp_path).add(scan("next"))
    assert [s.scan for s in read_manifest(tmp_path)] == ["chair-1@0", "next"]


@pytest.mark.parametrize("start", [float("nan"), 400.0, -1.0, float("inf")])
def test_a_start_that_is_no_azimuth_is_refused(start: float) -> None:
    with pytest.raises(InputError, match="from 0 up to 360"):
        RecordedObject("chair", "mine", "train", start)


def test_sets_of_other_settings_are_not_mixed(gathered: Path, tmp_path: Path) -> None:
    other = replace(QUICK, frame_interval=1.0)
    with pytest.raises(InputError, match=r"was gathered with frame_interval 2\.0, not 1\.0"):
        make(gathered, other)
    (tmp_path / "something").write_text("")
    with pytest.raises(InputError, match="holds something else"):
        make(tmp_path)


def test_a_line_that_an_interruption_cut_is_made_again(
    gathered: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (gathered / MANIFEST).read_text()
    for name in ("settings.json", MANIFEST):
        (tmp_path / name).write_text((gathered / name).read_text())
    (tmp_path / MANIFEST).write_text(text[:-20])
    asked: list[str] = []
    monkeypatch.setattr(
        LocalPool,
        "outcomes",
        lambda pool, jobs, work: asked.extend(job.key for job in jobs) or iter(()),
    )
    assert len(make(tmp_path)) == 3
    assert asked == ["bed-200000@090"]
    SetFolder(tmp_path).add(read_manifest(gathered)[3])
    assert (tmp_path / MANIFEST).read_text() == text


def test_scans_that_fail_are_reported_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        LocalPool,
        "outcomes",
        lambda pool, jobs, work: ((job, RuntimeError("killed")) for job in jobs),
    )
    with pytest.raises(OutputError, match="4 scans failed, the first: chair-200000@000"):
        make(tmp_path / "set")
    assert read_manifest(tmp_path / "set") == []


def run_gather(folder: str) -> None:
    make(Path(folder))


def test_a_kill_loses_only_the_scan_in_progress(tmp_path: Path) -> None:
    folder = tmp_path / "set"
    process = multiprocessing.get_context("spawn").Process(target=run_gather, args=(str(folder),))
    process.start()
    deadline = time.monotonic() + 90
    while time.monotonic() < deadline:
        if (folder / MANIFEST).is_file() and (folder / MANIFEST).read_text():
            break
        time.sleep(0.05)
    assert process.pid is not None
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    before = read_manifest(folder)
    assert 1 <= len(before) < 4
    scans = make(folder)
    assert [s.scan for s in scans[: len(before)]] == [s.scan for s in before]
    assert len({s.scan for s in scans}) == len(scans) == 4
    assert verify_gathered(folder).complete


def test_objects_are_split_not_scans() -> None:
    settings = GatherSettings(("chair", "toilet"), 3, 2, (0.0,), (0.0, 45.0, 16.9))
    tasks = settings.tasks(objects_for(settings))
    splits: dict[str, set[str]] = {}
    for task in tasks:
        splits.setdefault(task.object.name, set()).add(task.object.split)
    assert all(len(split) == 1 for split in splits.values())
    assert sum(split == {"test"} for split in splits.values()) == 2 * 2
    assert len({task.key for task in tasks}) == len(tasks) == 2 * (3 + 2 * 3)
    assert {task.start_deg for task in tasks if task.object.split == "train"} == {0.0}
    # More objects change nothing of those that were there.
    more = {one.name: one.split for one in objects_for(replace(settings, train_objects=5))}
    assert all(more[name] in split for name, split in splits.items())


def test_an_object_of_the_other_split_is_refused(gathered: Path, tmp_path: Path) -> None:
    folder = copied(gathered, tmp_path)
    moved = [replace(scan, split="test") for scan in read_manifest(folder)]
    (folder / MANIFEST).write_text("".join(scan.line() for scan in moved))
    with pytest.raises(InputError, match="holds chair-200000 in its test split"):
        make(folder, replace(QUICK, train_starts_deg=(45.0,)))
    assert verify_gathered(folder).complete, "nothing more is asked for"


@pytest.mark.parametrize(
    "wrong",
    [
        {"classes": ()}, {"sources": ()}, {"train_objects": -1},
        {"train_objects": 0, "test_objects": 0}, {"train_starts_deg": (), "test_starts_deg": ()},
        {"test_starts_deg": (360.0,)}, {"train_starts_deg": (float("nan"),)}, {"slip": 1.0},
        {"frame_interval": 0.0}, {"frames": 0},
    ],
)  # fmt: skip
def test_invalid_settings_are_refused(wrong: dict) -> None:
    with pytest.raises(InputError):
        GatherSettings(**wrong)


def test_a_gathered_set_is_a_data_set(gathered: Path) -> None:
    train = open_data_set(gathered, "train")
    assert train.classes == ("bed", "chair")
    assert train.names.tolist() == ["chair-200000@000", "bed-200000@000"], "from the first start"
    assert train.points_xyz.shape == (2, 4096, 3)
    every = read_gathered(gathered, "train")
    assert len(every) == 4
    np.testing.assert_array_equal(every.points_xyz[0], train.points_xyz[0])
    with pytest.raises(InputError, match="no scan of the test split"):
        open_data_set(gathered, "test")
    with pytest.raises(InputError, match="from 45°"):
        read_gathered(gathered, "train", [45.0])


def test_recordings_train_beside_simulated_scans(gathered: Path, tmp_path: Path) -> None:
    """With or without a measured start; other objects need no scan from these starts."""
    folder = tmp_path / "set"
    shutil.copytree(gathered, folder)
    files = {"cloud": "clouds/bed-200000@000.npz"}
    for name, start in (("blue@run1", None), ("red@run2", 30.0), ("red@run3", 50.0)):
        object_name = name.partition("@")[0]
        SetFolder(folder).add(
            scan(name, object=object_name, label="lamp", start_deg=start, files=files)
        )
    train = open_data_set(folder, "train")
    assert train.names.tolist()[2:] == ["blue@run1", "red@run2"], "from the first start"
    assert train.shown.tolist()[2:] == ["blue", "red"]
    assert train.classes == ("bed", "chair", "lamp")
    assert verify_gathered(folder).missing == ()


@given(st.integers(0, 2**32 - 1), st.integers(1, 50))
def test_points_are_drawn_by_area_and_always_the_same(seed: int, count: int) -> None:
    import tempfile

    rng = np.random.default_rng(seed)
    areas = rng.uniform(0.1, 1, count)
    areas[0] = 0.0 if count > 1 else 1.0
    cloud = PointCloud(rng.normal(size=(count, 3)), areas=areas)
    with tempfile.TemporaryDirectory() as folder:
        write_cloud(Path(folder) / "cloud.npz", cloud)
        drawn_points = read_points(Path(folder) / "cloud.npz", "one", 64)
        again = read_points(Path(folder) / "cloud.npz", "one", 64)
    np.testing.assert_array_equal(drawn_points, again)
    kept = cloud.points_xyz.astype(np.float32)[areas > 0]
    assert all((kept == point).all(axis=1).any() for point in drawn_points)


def scan(name: str = "chair-1@0", **changed: object) -> GatheredScan:
    fields = {"scan": name, "object": "chair-1", "label": "chair", "split": "train",
              "start_deg": 0.0, **changed}  # fmt: skip
    return GatheredScan(**fields)


@pytest.mark.parametrize(
    "line",
    [
        "no json\n", "[]\n", '{"scan": 3}\n', "{}\n",
        scan(split="both").line(), scan(files={"cloud": "../../secret.npz"}).line(),
        scan(files={"cloud": "/etc/passwd"}).line(), scan(files={"virus": "x"}).line(),
        scan(label=3).line(), scan(start_deg="45").line(), scan(start_deg=float("nan")).line(),
        scan(quality=[]).line(),
    ],
)  # fmt: skip
def test_a_broken_manifest_is_reported(tmp_path: Path, line: str) -> None:
    (tmp_path / MANIFEST).write_text(scan().line() + line + scan("other").line())
    with pytest.raises(InputError, match="line 2"):
        read_manifest(tmp_path)


def test_verify_names_missing_foreign_and_broken_files(gathered: Path, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    shutil.copytree(gathered, folder)
    (folder / "clouds" / "bed-200000@000.npz").write_bytes(b"broken")
    (folder / "grids" / "bed-200000@090.npz").unlink()
    (folder / "poses" / "stranger.txt").write_text("")
    SetFolder(folder).add(scan("chair-9@045", object="chair-9", start_deg=45.0, files={}))
    SetFolder(folder).add(
        scan("chair-200000@135", object="chair-200000", split="test", start_deg=135.0)
    )
    found = verify_gathered(folder)
    assert not found.complete
    assert found.foreign == ("poses/stranger.txt",)
    assert found.without_cloud == ("chair-9@045", "chair-200000@135")
    broken = [file for file, _ in found.broken]
    assert broken == ["clouds/bed-200000@000.npz", "grids/bed-200000@090.npz", MANIFEST]
    assert "chair-9 from 90°" in found.missing
    assert json.loads(json.dumps(found.to_dict()))["counts"] == {"train/bed": 2, "train/chair": 2}


def test_a_split_needs_only_its_own_starts(gathered: Path, tmp_path: Path) -> None:
    """To train on scans from 0° alone is the protocol, not a gap."""
    lines = [scan(f"{name}@{start:03.0f}", object=name, split=split, start_deg=start, files={})
             for name, split, starts in (("a", "train", (0.0,)), ("b", "test", (0.0, 45.0)))
             for start in starts]  # fmt: skip
    (tmp_path / MANIFEST).write_text("".join(line.line() for line in lines))
    assert verify_gathered(tmp_path).missing == ()


def test_the_contact_sheet_shows_every_scan(gathered: Path, tmp_path: Path) -> None:
    from PIL import Image

    draw_contact_sheet(tmp_path / "sheet.png", gathered, shown_scans(read_manifest(gathered)))
    with Image.open(tmp_path / "sheet.png") as sheet:
        assert sheet.size == (120 + 2 * 110, 18 + 2 * 110)
        pixels = np.asarray(sheet.convert("L"))
    for row in range(2):
        for column in range(2):
            cell = pixels[18 + 110 * row :, 120 + 110 * column :][:110, :110]
            assert (cell < 200).sum() > 100
    # Many objects from one start are no endless column.
    first, *_ = read_manifest(gathered)
    many = [replace(first, object=f"chair-{number}") for number in range(40)]
    draw_contact_sheet(tmp_path / "sheet.png", gathered, shown_scans(many))
    with Image.open(tmp_path / "sheet.png") as sheet:
        assert 1 < sheet.width / sheet.height < 2
    one_point = drawn(np.zeros((1, 3), np.float32))
    assert one_point.shape == (110, 110, 3)


def test_without_the_simulator_no_scan_is_recorded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise the scans would count as made once the simulator is installed."""
    broken = tmp_path / "modules" / "embreex"
    broken.mkdir(parents=True)
    (broken / "__init__.py").write_text("raise ImportError('none here')")
    monkeypatch.syspath_prepend(broken.parent)
    with pytest.raises(MissingExtraError, match=r"circumspect\[sim\]"):
        make(tmp_path / "set")
    assert read_manifest(tmp_path / "set") == []


def test_training_uses_the_first_scan_that_saw_its_object(gathered: Path, tmp_path: Path) -> None:
    folder = copied(gathered, tmp_path)
    scans = read_manifest(folder)
    blind = [replace(s, files={}) if s.label == "chair" and s.start_deg == 0 else s for s in scans]
    (folder / MANIFEST).write_text("".join(scan.line() for scan in blind))
    named = open_data_set(folder, "train").names.tolist()
    assert sorted(named) == ["bed-200000@000", "chair-200000@090"]


def test_missing_starts_are_reported_as_requested(gathered: Path, tmp_path: Path) -> None:
    """Settings are edited by hand, too."""
    folder = copied(gathered, tmp_path)
    settings = json.loads((folder / "settings.json").read_text())
    names = ["chair-1@000", "chair-1@000.5", "chair-1@090", "chair-1@337.5", "chair-1"]
    settings[ASKED] += names
    (folder / "settings.json").write_text(json.dumps(settings))
    missing = {name for name in verify_gathered(folder).missing if name.startswith("chair-1 ")}
    assert missing == {f"chair-1 from {start}°" for start in ("0", "0.5", "90", "337.5")}
