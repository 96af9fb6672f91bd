"""Objects of no known class, end to end on a little furniture."""

from __future__ import annotations

import json

import numpy as np
import pytest
from experiment_watcher import Watched
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets import GridCache, ObjectSet
from circumspect.errors import InputError
from circumspect_experiments import Unknown, reproduce_unknown
from circumspect_experiments.unknown import area_under_curve, other_things, without

QUICK = Unknown(epochs=1, yaw_count=2, each=1)
KINDS = ("plate", "post", "rod")


def three_kinds(count, seed):
    """Plates, posts and rods that lie, in turn; a tenth is not what it is called."""
    labels = np.arange(count, dtype=np.int64) % 3
    sizes = np.array([[1.0, 1.0, 0.1], [0.15, 0.15, 1.0], [1.0, 0.15, 0.15]])
    cube = np.random.default_rng(seed).random((count, 300, 3)) - 0.5
    clouds = (cube * sizes[labels, None]).astype(np.float32)
    labels[::10] = (labels[::10] + 1) % 3
    names = np.array([f"{KINDS[k]}_{i:04d}" for i, k in enumerate(labels)])
    return ObjectSet(clouds, labels, names, KINDS)


def test_without_removes_all_objects_of_a_class():
    objects = three_kinds(30, 0)
    known, rest = without(objects, 1)
    assert known.classes == rest.classes == ("plate", "rod")
    assert len(known) + len(rest) == 30
    assert {name.split("_")[0] for name in rest.names} == {"post"}
    for name, label in zip(known.names, known.labels, strict=True):
        assert name.startswith(known.classes[label])


@given(st.integers(0, 99), st.integers(1, 30), st.integers(1, 30))
def test_auroc_is_the_probability_of_the_correct_order(seed, n, m):
    rng = np.random.default_rng(seed)
    known, unknown = rng.integers(0, 5, n) / 5, rng.integers(0, 5, m) / 5
    pairs = known[:, None] - unknown[None]
    by_hand = (pairs > 0).mean() + (pairs == 0).mean() / 2
    assert area_under_curve(known, unknown) == pytest.approx(by_hand)


def test_other_things_are_many_and_named():
    others = other_things(KINDS, 2, 100)
    assert others.points_xyz.shape == (26, 100, 3)
    assert len(set(others.names)) == 26


def test_every_class_is_left_out_once(tmp_path, monkeypatch):
    def run(settings=QUICK, watched=None):
        return reproduce_unknown(
            three_kinds(30, 0), three_kinds(12, 1), settings, tmp_path / "out", watched or Watched(),
            GridCache(tmp_path / "grids"),
        )  # fmt: skip

    shown = []
    monkeypatch.setattr(
        "circumspect_experiments.unknown.require_shipped_classes", lambda *given: None
    )
    monkeypatch.setattr(
        "circumspect_experiments.unknown._of_shipped",
        lambda *given: (
            shown.append(given) or {"unknown_beyond": 0.5, "called_unknown": {"car": 1.0}}
        ),
    )
    document = run()
    assert list(document["left_out"]) == list(KINDS)
    for row in document["left_out"].values():
        for key in ("accuracy", "known_called_known", "left_out_called_unknown"):
            assert 0 <= row[key] <= 1
    text = (tmp_path / "out" / "unknown.md").read_text()
    assert text.count("\n| ") == (2 + 3 + 1) + (2 + 1 + 1), "heads, rows and means"
    again = Watched()
    assert run(watched=again) == document
    assert again.steps == [], "nothing is trained or measured again"
    assert f"`{document['command']}`" in text
    made = json.loads((tmp_path / "out" / "without-plate" / "training" / "config.json").read_text())
    assert made["settings"]["replicas"] == QUICK.epochs
    with pytest.raises(InputError, match="other settings"):
        run(Unknown(epochs=2, yaw_count=2, each=1))


def test_the_shipped_classifier_sees_other_things(tmp_path):
    from circumspect.furniture import CATEGORIES
    from circumspect_experiments.unknown import _of_shipped

    found = _of_shipped(CATEGORIES, QUICK, tmp_path, Watched())
    assert len(found["called_unknown"]) == 13
    assert all(0 <= share <= 1 for share in found["called_unknown"].values())
