"""The paper's experiment end to end, on a handful of plates and posts."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from experiment_watcher import Watched
from matplotlib.image import imread
from two_kinds import two_kinds

from circumspect.datasets import GridCache
from circumspect.errors import InputError
from circumspect.reproduction import Table2, reproduce_table2
from circumspect.reproduction.published import ANGLES_DEG, MODELNET10
from circumspect.reproduction.stages import is_done

QUICK = Table2(epochs=2, yaw_count=5, shape=(14, 14, 14))


def run(tmp_path, how=QUICK, watched=None, test=None):
    return reproduce_table2(
        two_kinds(40), test or two_kinds(10, seed=1), how, tmp_path / "out", watched or Watched(),
        GridCache(tmp_path / "grids"),
    )  # fmt: skip


def test_the_table_stands_beside_the_papers_and_is_made_once(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, watched=Watched("cylindrical-rwmp"))
    goes_on = Watched()
    document = run(tmp_path, watched=goes_on)
    trained = [step for step in goes_on.steps if step in {f"{g}-{p}" for g, p in MODELNET10}]
    assert set(trained) == {"cylindrical-rwmp"}

    out = tmp_path / "out"
    assert json.loads((out / "table2.json").read_text()) == json.loads(json.dumps(document))
    assert {
        (row["grid"], row["pool"]): tuple(row["paper"]) for row in document["rows"]
    } == MODELNET10
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

    with pytest.raises(InputError, match="other settings; choose another --out"):
        run(tmp_path, Table2(epochs=3, yaw_count=5, shape=(14, 14, 14)))
    with pytest.raises(InputError, match="other data; choose another --out"):
        run(tmp_path, test=two_kinds(10, seed=2))
    with pytest.raises(InputError, match="other yaw_deg"):
        run(tmp_path, Table2(epochs=2, yaw_count=6, shape=(14, 14, 14)))


def test_a_broken_note_of_what_a_result_is_made_of_is_named(tmp_path):
    (tmp_path / "made_of.json").write_text("{")
    with pytest.raises(InputError, match=r"made_of\.json"):
        is_done(tmp_path, {"data": 1})
    assert not is_done(tmp_path / "nowhere", {"data": 1})


@pytest.mark.parametrize("text", ["[]", "null", "3", '["data"]'])
def test_a_note_that_is_no_object_is_that_of_something_else(tmp_path, text):
    (tmp_path / "made_of.json").write_text(text)
    with pytest.raises(InputError, match=r"made_of\.json: tells of no result.* --out"):
        is_done(tmp_path, {"data": 1})
