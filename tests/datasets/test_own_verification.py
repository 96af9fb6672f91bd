"""Sets of other classes than ModelNet10's are counted as they are."""

import json

import numpy as np
import pytest

from circumspect.cli.main import main
from circumspect.datasets import ObjectSet, open_data_set
from circumspect.datasets.own_verification import has_own_classes, verify_own
from circumspect.datasets.point_pack import write_point_pack
from circumspect.errors import InputError

OFF = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n"


def write_pack(path, names, labels, classes=("bench", "stool")):
    points = np.random.default_rng(0).random((len(names), 8, 3), np.float32)
    write_point_pack(path, ObjectSet(points, np.array(labels), np.array(names), classes))


def write_meshes(root, *places):
    for place in places:
        (root / place).parent.mkdir(parents=True, exist_ok=True)
        (root / place).write_text(OFF)


@pytest.fixture
def packs(tmp_path):
    write_pack(tmp_path / "train.npz", ["bench_0001", "bench_0002", "stool_0001"], [0, 0, 1])
    write_pack(tmp_path / "test.npz", ["stool_0002"], [1])
    return tmp_path


def verified(folder, capsys):
    code = main(["data", "verify", str(folder), "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_packs_are_counted_by_their_own_classes(packs, capsys):
    assert main(["data", "verify", str(packs)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines[:3]] == [
        ["class", "train", "test"], ["bench", "2", "0"], ["stool", "1", "1"],
    ]  # fmt: skip
    assert lines[3:] == [f"{packs}: classes of your own, not ModelNet10's; all of it can be read"]
    code, document = verified(packs, capsys)
    assert (code, document["complete"], document["own_classes"]) == (0, True, True)
    assert document["counts"]["train"] == {"bench": 2, "stool": 1}
    assert document["missing"] == document["foreign"] == document["broken"] == []


def test_a_lone_pack_is_counted(packs, capsys):
    (packs / "test.npz").unlink()
    code, document = verified(packs, capsys)
    assert code == 0
    assert document["counts"]["test"] == {"bench": 0, "stool": 0}


def test_a_broken_pack_is_named(packs, capsys):
    (packs / "test.npz").write_bytes(b"PK")
    code, document = verified(packs, capsys)
    assert code == 1
    assert [entry["file"] for entry in document["broken"]] == ["test.npz"]
    assert document["counts"]["train"] == {"bench": 2, "stool": 1}
    assert main(["data", "verify", str(packs)]) == 1
    assert "own, not ModelNet10's; not all of it can be read" in capsys.readouterr().out


def test_unreadable_packs_are_no_empty_modelnet10(packs, capsys):
    for split in ("train", "test"):
        (packs / f"{split}.npz").write_bytes(b"PK")
    code, document = verified(packs, capsys)
    assert (code, len(document["broken"]), document["missing"]) == (1, 2, [])


@pytest.mark.parametrize(
    ("names", "fault"),
    [
        (["bench_0001", "bench_0001"], "1 objects are in it more than once, as bench_0001 is"),
        (["stool_0009", "bench_0002"], "stool_0009 is labelled bench; name or label is wrong"),
    ],
)
def test_a_contradictory_pack_is_reported(packs, capsys, names, fault):
    write_pack(packs / "train.npz", names, [0, 0])
    code, document = verified(packs, capsys)
    assert code == 1
    assert [fault in entry["error"] for entry in document["broken"]] == [True]


def test_meshes_are_counted_by_their_folders(tmp_path, capsys):
    write_meshes(tmp_path, "cup/train/a.off", "cup/train/b.OFF", "jug/test/a.off", "jug/more/c.off")
    (tmp_path / "jug" / "train").mkdir()
    (tmp_path / "jug" / "train" / "d.off").write_text("OFF\n9 9 0\n0 0")
    found = verify_own(tmp_path)
    assert found.classes == ("cup", "jug")
    assert found.counts == {("train", "cup"): 2, ("test", "jug"): 1}
    assert found.foreign == ("jug/more/c.off",)
    assert [file for file, _ in found.broken] == ["jug/train/d.off"]
    assert main(["data", "verify", str(tmp_path)]) == 1
    (tmp_path / "jug" / "train" / "d.off").unlink()
    capsys.readouterr()
    assert main(["data", "verify", str(tmp_path)]) == 0


def test_files_that_no_reader_can_read_are_broken(tmp_path, capsys):
    write_meshes(tmp_path, "cup/train/a.off", "cup/train/b.off", "cup/train/c.Off")
    (tmp_path / "cup" / "train" / "c.Off").write_text("no mesh")
    line = OFF.replace("0 1 0", "2 0 0").replace("0 0 1\n", "3 0 0\n")
    (tmp_path / "cup" / "train" / "b.off").write_text(line)
    (tmp_path / "cup" / "train" / "d.off").symlink_to("nowhere.off")
    (tmp_path / "cup" / "train" / "e.off").mkdir()
    found = verify_own(tmp_path)
    assert found.counts == {("train", "cup"): 1}
    names = ["b.off", "c.Off", "d.off", "e.off"]
    assert [file for file, _ in found.broken] == [f"cup/train/{name}" for name in names]
    assert "no area" in found.broken[0][1]
    assert main(["data", "verify", str(tmp_path)]) == 1
    assert "Traceback" not in capsys.readouterr().err


def test_a_mesh_without_area_is_named_where_it_is_sampled(tmp_path):
    write_meshes(tmp_path, "cup/train/a.off")
    flat = tmp_path / "cup" / "train" / "b.off"
    flat.write_text(OFF.replace("0 1 0", "2 0 0").replace("0 0 1\n", "3 0 0\n"))
    with pytest.raises(InputError, match=r"b\.off: the mesh has no area"):
        open_data_set(tmp_path, "train")


@pytest.mark.parametrize(
    ("classes", "each", "own"),
    [
        (["cup"], 1, True),
        (["chair", "stool"], 1, True),
        (["chair", "sofa"], 9, True),
        (["chair", "sofa", "stool"], 9, True),
        (["bathtub"], 80, False),
        (["bathtub", "stool"], 80, False),
        ([], 0, False),
    ],
)
def test_set_is_a_copy_of_modelnet10_where_it_holds_half_of_a_class(tmp_path, classes, each, own):
    for name in classes:
        write_meshes(tmp_path, *(f"{name}/train/{name}_{i:04d}.off" for i in range(1, each + 1)))
    write_meshes(tmp_path, "unpacked/deeper/cup/train/a.off")
    assert has_own_classes(tmp_path) is own
    if classes and own:
        assert main(["data", "verify", str(tmp_path)]) == 0


def test_packs_of_few_models_of_modelnet10_are_a_set_of_their_own(tmp_path):
    write_pack(tmp_path / "train.npz", ["chair_0001", "sofa_0001"], [0, 1], ("chair", "sofa"))
    assert has_own_classes(tmp_path)
    names = [f"bathtub_{i:04d}" for i in range(1, 90)]
    write_pack(tmp_path / "train.npz", names, [0] * 89, ("bathtub", "stool"))
    assert not has_own_classes(tmp_path)


def test_a_broken_modelnet10_is_named_as_such(tmp_path, capsys):
    folder = tmp_path / "ModelNet10"
    write_meshes(folder, "chair/train/chair_0001.off", "sofa/test/sofa_0681.off")
    code, document = verified(folder, capsys)
    assert code == 1
    assert len(document["missing"]) == 4897
    assert "own_classes" not in document
