"""The paper's experiment end to end, on a handful of plates and posts."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from experiment_watcher import Watched
from little_furniture import furniture
from matplotlib.image import imread
from two_kinds import two_kinds

from circumspect import __version__
from circumspect.classification import GridSpec
from circumspect.datasets import Augmentation, GridCache
from circumspect.errors import InputError
from circumspect.training.run_config import run_config
from circumspect_experiments import (
    Comparison,
    Table2,
    Unknown,
    reproduce_rivals,
    reproduce_table2,
    reproduce_unknown,
)
from circumspect_experiments.stages import is_done, trained
from circumspect_experiments.whole_set import ANGLES_DEG, PUBLISHED_ACCURACY

QUICK = Table2(epochs=2, yaw_count=5, shape=(14, 14, 14))


def run(tmp_path, settings=QUICK, watched=None, test=None):
    return reproduce_table2(
        furniture(4, 0), test or furniture(1, 500), settings, tmp_path / "out", watched or Watched(),
        GridCache(tmp_path / "grids"),
    )  # fmt: skip


def test_the_table_resumes_and_shows_the_figures_of_the_paper(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, watched=Watched("cylindrical-rwmp"))
    goes_on = Watched()
    document = run(tmp_path, watched=goes_on)
    again_trained = [
        step for step in goes_on.steps if step in {f"{g}-{p}" for g, p in PUBLISHED_ACCURACY}
    ]
    assert set(again_trained) == {"cylindrical-rwmp"}

    out = tmp_path / "out"
    assert json.loads((out / "table2.json").read_text()) == json.loads(json.dumps(document))
    assert {
        (row["grid"], row["pool"]): tuple(row["paper"]) for row in document["rows"]
    } == PUBLISHED_ACCURACY
    for row in document["rows"]:
        assert row["yaw_deg"] == list(ANGLES_DEG)
        assert len(row["accuracy"]) == 4
        metrics = json.loads(
            (out / f"{row['grid']}-{row['pool']}" / "angles" / "metrics.json").read_text()
        )
        assert metrics["accuracy"] == row["accuracy"]
        assert row["training"]["epoch"] in (1, 2)
        assert 0 <= row["training"]["validation_accuracy"] <= 1
        assert 0 < row["training"]["minutes"] < 10
    text = (out / "table2.md").read_text()
    assert "(0.87) |" in text
    assert text.count("| cylindrical") == 4
    assert "was kept" in text
    assert "`circumspect reproduce table2 --data modelnet10 --epochs 2 --yaw-count 5" in text
    figures = re.findall(r"!\[[^]]*\]\(([^)]*)\)", text)
    assert len(figures) == 5
    assert all((out / figure).is_file() for figure in figures)
    for figure in ("accuracy_over_yaw.png", "confusion_cylindrical_rwmp.png"):
        assert np.ptp(imread(out / figure)[..., :3]) > 0.5
    assert not list(out.rglob("state.safetensors"))

    before = {path: path.stat().st_mtime_ns for path in out.rglob("best.safetensors")}
    again = Watched()
    assert run(tmp_path, watched=again) == document
    assert all("-" not in step or " " in step for step in again.steps)
    assert before == {path: path.stat().st_mtime_ns for path in out.rglob("best.safetensors")}

    with pytest.raises(InputError, match=r"other settings\.epochs \(2, not 3\); choose another"):
        run(tmp_path, Table2(epochs=3, yaw_count=5, shape=(14, 14, 14)))
    with pytest.raises(InputError, match="other data; choose another --out"):
        run(tmp_path, test=furniture(1, 600))
    with pytest.raises(InputError, match="other yaw_deg"):
        run(tmp_path, Table2(epochs=2, yaw_count=6, shape=(14, 14, 14)))


def without(objects, kind):
    """The pack may list the class, but holds nothing of it."""
    return objects.subset(objects.labels != objects.classes.index(kind))


def test_a_set_without_all_classes_is_refused(tmp_path):
    train, test = furniture(4, 0), furniture(1, 500)
    for splits, why in (
        ((without(train, "toilet"), test), "the training split lacks toilet; this"),
        ((train, without(without(test, "toilet"), "bed")), "the test split lacks bed and toilet;"),
        ((two_kinds(8), test), "lacks bathtub and .* and toilet, the training split has plate and"),
    ):
        for experiment, settings in (
            (reproduce_table2, QUICK),
            (reproduce_unknown, Unknown()),
            (reproduce_rivals, Comparison()),
        ):
            watched = Watched()
            with pytest.raises(InputError, match=f"--data: .*{why}.*data verify"):
                experiment(*splits, settings, tmp_path / "out", watched)
            assert watched.steps == []
    assert not (tmp_path / "out").exists()


def as_before_a_setting_was_there(file):
    """What a state of this version wrote that knew no `damage`."""
    document = json.loads(file.read_text())
    del document["settings"]["augmentation"]["damage"]
    file.write_text(json.dumps(document))


def test_a_training_without_a_newer_setting_is_reused(tmp_path):
    settings, objects = QUICK.settings("planes"), two_kinds(10)
    input_spec, at, cache = GridSpec(), tmp_path / "run", GridCache(tmp_path / "grids")
    at.mkdir()
    (at / "best.safetensors").touch()
    for name in ("made_of.json", "config.json"):
        made = {"circumspect": __version__, **run_config(settings, input_spec, objects.digest)}
        (at / name).write_text(json.dumps(made))
        as_before_a_setting_was_there(at / name)
    assert trained(objects, settings, input_spec, at, Watched(), cache) == at / "best.safetensors"
    damaged = replace(settings, augmentation=Augmentation(damage=0.5))
    named = r"other settings\.augmentation\.damage \(0\.0, not 0\.5\); choose another --out"
    with pytest.raises(InputError, match=named):
        trained(objects, damaged, input_spec, at, Watched(), cache)


def train_briefly(tmp_path, watched=None):
    settings = replace(QUICK.settings("planes"), replicas=1)
    cache = GridCache(tmp_path / "grids")
    at = tmp_path / "run"
    return trained(two_kinds(20), settings, GridSpec(), at, watched or Watched(), cache)


def interrupted(tmp_path):
    """After the first epoch of two."""
    watched = Watched("run")
    with pytest.raises(KeyboardInterrupt), watched.training("run", 2):
        train_briefly(tmp_path, watched)


@pytest.mark.parametrize("version", [None, "0.0.9"])
def test_a_training_of_another_version_is_not_taken_for_one_of_this(tmp_path, version):
    train_briefly(tmp_path)
    note = tmp_path / "run" / "made_of.json"
    made_of = json.loads(note.read_text())
    assert made_of.pop("circumspect") == __version__
    note.write_text(json.dumps(made_of if version is None else {"circumspect": version, **made_of}))
    why = r'other circumspect \("0\.0\.9", not ' if version else "not state which version"
    with pytest.raises(InputError, match=rf"run: .*{why}.*; choose another --out"):
        train_briefly(tmp_path)


def test_an_interrupted_training_resumes_only_in_its_own_version(tmp_path, monkeypatch):
    interrupted(tmp_path)
    monkeypatch.setattr("circumspect_experiments.stages.__version__", "9.0")
    with pytest.raises(InputError, match=rf"version {__version__} began, not 9\.0; choose another"):
        train_briefly(tmp_path)
    monkeypatch.undo()
    train_briefly(tmp_path)
    assert len((tmp_path / "run" / "epochs.csv").read_text().splitlines()) == 1 + QUICK.epochs


def test_an_interrupted_training_without_a_version_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("circumspect.training.resume.VERSION", "of_something_else")
    interrupted(tmp_path)
    monkeypatch.undo()
    with pytest.raises(InputError, match="not state which version"):
        train_briefly(tmp_path)


@pytest.mark.parametrize("count", [0, -3, 3601])
def test_no_yaws_are_refused_before_anything_is_done(count):
    with pytest.raises(InputError, match=f"--yaw-count must be 1 to 3600, not {count}"):
        Table2(yaw_count=count)


def test_a_broken_made_of_file_is_named(tmp_path):
    (tmp_path / "made_of.json").write_text("{")
    with pytest.raises(InputError, match=r"made_of\.json"):
        is_done(tmp_path, {"data": 1})
    assert not is_done(tmp_path / "nowhere", {"data": 1})


@pytest.mark.parametrize("text", ["[]", "null", "3", '["data"]'])
def test_a_made_of_file_without_an_object_is_refused(tmp_path, text):
    (tmp_path / "made_of.json").write_text(text)
    with pytest.raises(InputError, match=r"made_of\.json: describes no result.* --out"):
        is_done(tmp_path, {"data": 1})
