"""Whether a copy of ModelNet10 is complete."""

import json

import numpy as np
import pytest

from circumspect.cli.main import main
from circumspect.datasets import ObjectSet
from circumspect.datasets.point_pack import write_point_pack
from circumspect.datasets.verification import MODELNET10, expected_names, verify
from circumspect.errors import InputError

OFF = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n"


@pytest.fixture
def off_folder(tmp_path):
    """A complete copy, each mesh a tetrahedron, with a foreign file in it."""
    root = tmp_path / "ModelNet10"
    for split, names in expected_names().items():
        for name in names:
            folder = root / name.rpartition("_")[0] / split
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"{name}.off").write_text(OFF)
    (root / "README.txt").write_text("hello")
    return root


def test_the_official_numbers():
    names = expected_names()
    assert (len(names["train"]), len(names["test"])) == (3991, 908)
    assert not set(names["train"]) & set(names["test"])


def test_a_whole_copy_is_complete(off_folder, capsys):
    assert main(["data", "verify", str(off_folder), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["complete"]
    assert document["foreign"] == ["README.txt"]
    assert document["counts"]["test"] == {name: test for name, (_, test) in MODELNET10.items()}


def test_missing_broken_and_misplaced_files_are_named(off_folder, capsys):
    (off_folder / "chair" / "train" / "chair_0007.off").unlink()
    (off_folder / "desk" / "test" / "desk_0201.off").write_text("OFF\n9 9 0\n0 0")
    misplaced = off_folder / "sofa" / "train" / "sofa_0700.off"
    (off_folder / "sofa" / "test" / "sofa_0700.off").rename(misplaced)
    found = verify(off_folder)
    assert not found.complete
    assert set(found.missing) == {("train", "chair_0007"), ("test", "sofa_0700")}
    assert [file for file, _ in found.broken] == ["desk/test/desk_0201.off"]
    assert "sofa/train/sofa_0700.off" in found.foreign
    assert found.counts["train", "chair"] == 888
    assert main(["data", "verify", str(off_folder)]) == 1
    text = capsys.readouterr().out
    assert "chair_0007" in text
    assert "desk_0201.off" in text
    assert text.endswith(": not complete\n")
    assert max(map(len, text.splitlines()[:11])) <= 80


def test_a_suffix_in_capitals_is_read_as_training_reads_it(off_folder):
    file = off_folder / "chair" / "train" / "chair_0007.off"
    file.rename(file.with_suffix(".OFF"))
    found = verify(off_folder)
    assert found.complete
    assert found.foreign == ("README.txt",)


def test_a_missing_class_is_reported_in_one_line(off_folder, capsys):
    for file in (off_folder / "bed").rglob("*.off"):
        file.unlink()
    assert main(["data", "verify", str(off_folder)]) == 1
    assert "and 607 more" in capsys.readouterr().out


def test_packs_are_compared_by_their_names(tmp_path, capsys):
    for split, names in expected_names().items():
        classes = tuple(MODELNET10)
        labels = np.array([classes.index(name.rpartition("_")[0]) for name in names])
        points = np.random.default_rng(0).random((len(names), 4, 3)).astype(np.float32)
        write_point_pack(
            tmp_path / f"{split}.npz", ObjectSet(points, labels, np.array(names), classes)
        )
    assert main(["data", "verify", str(tmp_path)]) == 0
    (tmp_path / "test.npz").write_bytes(b"PK")
    found = verify(tmp_path)
    assert [file for file, _ in found.broken] == ["test.npz"]
    assert len(found.missing) == 908


def test_labels_that_disagree_with_names_are_an_error(tmp_path, capsys):
    classes = (*MODELNET10, "stool")
    for split, names in expected_names().items():
        labels = np.array([classes.index(name.rpartition("_")[0]) for name in names])
        if split == "test":
            labels[:50] += 1
        points = np.random.default_rng(0).random((len(names) + 1, 4, 3)).astype(np.float32)
        more = np.array([*names, "bar_stool"]), np.array([*labels, 10])
        write_point_pack(tmp_path / f"{split}.npz", ObjectSet(points, more[1], more[0], classes))
    assert main(["data", "verify", str(tmp_path)]) == 1
    text = capsys.readouterr().out
    assert "50 of 909 labels disagree with the names, as that of bathtub_0107, which is bed" in text
    found = verify(tmp_path)
    assert [file for file, _ in found.broken] == ["test.npz"]
    assert not found.missing


def test_neither_packs_nor_meshes(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        verify(tmp_path / "nowhere")
    with pytest.raises(InputError, match="neither point packs"):
        verify(tmp_path)


def test_the_development_packs_are_complete(data_folder):
    assert verify(data_folder / "modelnet10").complete


def named_pack(path, names):
    points = np.random.default_rng(0).random((len(names), 8, 3), np.float32)
    classes = tuple(MODELNET10)
    labels = np.array([classes.index(name.rpartition("_")[0]) for name in names])
    write_point_pack(path, ObjectSet(points, labels, np.array(names), classes))


@pytest.mark.parametrize(
    ("more", "fault"),
    [
        ("test", "908 objects belong to the other split, as bathtub_0107 does"),
        ("train", "100 objects are in it more than once, as bathtub_0001 is"),
    ],
)
def test_a_training_pack_that_holds_more_than_it_should(tmp_path, more, fault):
    """All objects of a pack are trained on, unlike a foreign file in a folder."""
    names = expected_names()
    named_pack(tmp_path / "test.npz", names["test"])
    named_pack(tmp_path / "train.npz", names["train"])
    assert verify(tmp_path).complete
    added = names[more] if more == "test" else names[more][:100]
    named_pack(tmp_path / "train.npz", names["train"] + added)
    found = verify(tmp_path)
    assert not found.complete
    assert [fault in text for _, text in found.broken] == [True]
