"""Which objects are gathered: from several sources, and none in both splits."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.gathering import GatherSettings, objects_for
from circumspect.gathering.object_selection import select_objects
from circumspect.gathering.object_source import FURNITURE, ObjectSource, sources_of
from circumspect.geometry import TriangleMesh


@dataclass(frozen=True)
class Chairs:
    """Chairs of given variants, sizes and turns."""

    made: tuple[tuple[int, float, float], ...]

    def mesh(self, index: int) -> TriangleMesh:
        variant, scale, yaw = self.made[index]
        mesh = make_furniture("chair", variant)
        turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
        return TriangleMesh(scale * mesh.vertices_xyz @ turn.T, mesh.faces)


def chairs(prefix: str, *made: tuple[int, float, float]) -> LabelledSurfaces:
    names = np.array([f"{prefix}{number}" for number in range(len(made))])
    labels = np.full(len(made), "chair")
    return LabelledSurfaces(Chairs(made), np.arange(len(made)), labels, names, "")


def test_sources_alternate_until_they_are_exhausted() -> None:
    few = ObjectSource("few", chairs("a", (1, 1, 0), (2, 1, 0)), chairs("b", (9, 1, 0)))
    counts = {"train": 5, "test": 2}
    sources = [few, ObjectSource.procedural(counts)]
    chosen = select_objects(sources, ["chair"], counts)
    train = [(one.source, one.name) for one in chosen if one.split == "train"]
    assert [source for source, _ in train] == ["few", FURNITURE, "few", FURNITURE, FURNITURE]
    assert [name for _, name in train[::2]] == ["a0", "a1", "chair-200002"]
    assert Counter(one.split for one in chosen) == counts


def test_the_same_model_is_not_in_both_splits() -> None:
    """Not smaller either, nor turned by a right angle."""
    train = chairs("a", (1, 1, 0), (1, 0.8, np.pi / 2), (2, 1, 0), (1, 1, -np.pi / 2), (3, 1, 0))
    source = ObjectSource("mine", train, chairs("b", (1, 1.0, 0.0)))
    shown: list[tuple[int, int]] = []
    chosen = select_objects(
        [source], ["chair"], {"train": 2, "test": 1}, lambda *what: shown.append(what)
    )
    assert [one.name for one in chosen] == ["b0", "a2", "a4"]
    assert shown == [(1, 3), (2, 3), (3, 3)]
    with pytest.raises(InputError, match="2 objects of class chair to train with; 3 are requested"):
        select_objects([source], ["chair"], {"train": 3, "test": 1})


def test_an_object_too_large_for_the_camera_is_left_out() -> None:
    train = chairs("a", (1, 20.0, 0.0), (2, 1.0, 0.0))
    chosen = select_objects(
        [ObjectSource("mine", train, chairs("b"))], ["chair"], {"train": 1, "test": 0}
    )
    assert [one.name for one in chosen] == ["a1"]


def test_two_objects_of_one_name_are_reported() -> None:
    source = ObjectSource("mine", chairs("same/", (1, 1, 0)), chairs("same_", (2, 1, 0)))
    with pytest.raises(InputError, match=r"mine \(test\) and mine \(train\) both hold .* same_0"):
        select_objects([source], ["chair"], {"train": 1, "test": 1})


def test_a_source_that_is_not_there_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere"):
        sources_of([str(tmp_path / "nowhere")], {"train": 1, "test": 1})
    settings = GatherSettings(("chair", "unicorn"), 1, 1)
    with pytest.raises(InputError, match="no source has objects of class unicorn; there are bath"):
        objects_for(settings)


def test_objects_of_data_sets_stand_on_the_floor_in_metres(data_folder: Path) -> None:
    packs = data_folder / "modelnet10", data_folder / "sweethome3d" / "meshes.npz"
    counts = {"train": 2, "test": 2}
    sources = sources_of([str(path) for path in packs], counts)
    chosen = select_objects(sources, ["chair", "table"], counts)
    assert {one.source for one in chosen} == {"modelnet10", "meshes"}
    for one in chosen:
        low, high = (f(one.mesh().vertices_xyz, axis=0) for f in (np.min, np.max))
        assert abs(low[2]) < 1e-3
        assert 0.3 < (high - low).max() < 4
        assert "/" not in one.name
        if one.source == "modelnet10":
            assert one.name.startswith(one.label)
