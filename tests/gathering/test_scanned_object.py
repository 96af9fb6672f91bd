"""The object that a scan is of: furniture, a mesh file, or an object of a data set."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from circumspect.datasets import ObjectSet
from circumspect.datasets.off_folder import read_off_folder
from circumspect.datasets.point_pack import write_point_pack
from circumspect.errors import CircumspectError, InputError
from circumspect.furniture import make_furniture
from circumspect.gathering.scanned_object import scanned_object
from circumspect.geometry import TriangleMesh


def write_off(path: Path, mesh: TriangleMesh) -> None:
    lines = ["OFF", f"{len(mesh.vertices_xyz)} {len(mesh.faces)} 0"]
    lines += [f"{x} {y} {z}" for x, y, z in mesh.vertices_xyz]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces]
    path.write_text("\n".join(lines))


@pytest.fixture(scope="module")
def packs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("packs")
    for split, number in (("train", 1), ("test", 2)):
        points = make_furniture("chair", number).sampled(1024, 0).points_xyz
        clouds = (points - points.min(axis=0)) / np.ptp(points, axis=0).max()
        write_point_pack(
            folder / f"{split}.npz",
            ObjectSet(
                clouds[None].astype(np.float32), np.array([0]),
                np.array([f"chair_000{number}"]), ("chair",),
            ),
        )  # fmt: skip
    return folder


def test_furniture_with_and_without_a_variant() -> None:
    drawn = scanned_object("night_stand", 17)
    named = scanned_object("night_stand-17", 3)
    assert drawn.name == named.name == "night_stand-17"
    assert drawn.label == "night_stand"
    np.testing.assert_array_equal(drawn.mesh.vertices_xyz, named.mesh.vertices_xyz)


def test_a_mesh_file_is_stood_up_and_scaled(chair_obj: Path) -> None:
    scanned = scanned_object(str(chair_obj), 0, "y", 0.9)
    low, high = scanned.mesh.vertices_xyz.min(axis=0), scanned.mesh.vertices_xyz.max(axis=0)
    assert scanned.label is None
    assert low[2] == pytest.approx(0.0, abs=1e-9)
    assert high[2] == pytest.approx(0.9)
    np.testing.assert_allclose((low + high)[:2], 0.0, atol=1e-9)
    shape = make_furniture("chair", 3).vertices_xyz
    assert np.ptp(scanned.mesh.vertices_xyz[:, 0]) == pytest.approx(
        np.ptp(shape[:, 0]) * 0.9 / np.ptp(shape[:, 2]), rel=1e-6
    )


@pytest.mark.parametrize("flags", [{"up": "y"}, {"height": 3.0}])
@pytest.mark.parametrize("name", ["chair-3", "chair_0001"])
def test_up_and_height_are_for_mesh_files_only(
    packs: Path, name: str, flags: dict[str, Any]
) -> None:
    data = packs if name == "chair_0001" else None
    with pytest.raises(InputError, match="--up and --height are for mesh files"):
        scanned_object(name, 0, data=data, **flags)


@pytest.mark.parametrize("name", ["chair_0001", "chair_0002"])
def test_objects_of_packs_are_found_in_either_split(packs: Path, name: str) -> None:
    scanned = scanned_object(name, 0, data=packs)
    assert (scanned.name, scanned.label) == (name, "chair")
    assert np.ptp(scanned.mesh.vertices_xyz, axis=0).max() == pytest.approx(0.9, abs=0.02)


def test_off_folder_and_its_pack_give_the_same_object(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for number, split in ((1, "train"), (2, "test")):
        folder = tmp_path / "off" / "chair" / split
        folder.mkdir(parents=True)
        write_off(folder / f"chair_000{number}.off", make_furniture("chair", number))
    (tmp_path / "off" / "chair" / "train" / "chair_0003.off").write_text("broken")
    scanned = scanned_object("chair_0002", 0, data=tmp_path / "off")
    assert (scanned.name, scanned.label) == ("chair_0002", "chair")
    assert not (tmp_path / "cache").exists(), "other files are not read"
    write_point_pack(tmp_path / "test.npz", read_off_folder(tmp_path / "off", "test"))
    packed = scanned_object("chair_0002", 0, data=tmp_path / "test.npz")
    size = np.ptp(packed.mesh.vertices_xyz, axis=0)
    np.testing.assert_allclose(np.ptp(scanned.mesh.vertices_xyz, axis=0), size, atol=1e-4)
    assert len(scanned.mesh.vertices_xyz) == len(packed.mesh.vertices_xyz) == 1024
    with pytest.raises(InputError, match="no object 'chair_0004'"):
        scanned_object("chair_0004", 0, data=tmp_path / "off")
    with pytest.raises(CircumspectError, match=r"chair_0003\.off"):
        scanned_object("chair_0003", 0, data=tmp_path / "off")


@pytest.mark.parametrize(
    ("words", "error"),
    [
        ({"words": "chiar"}, "'chiar'.*bathtub, bed"),
        ({"words": "chair-"}, "no object"),
        ({"words": "gone.obj"}, "gone.obj: no such file"),
        ({"words": "."}, r"\.: is a folder; give a mesh file"),
        ({"words": "chair_0890"}, "--data says where"),
        ({"words": "chair", "height": 1.0}, "--height"),
        ({"words": "chair", "up": "y"}, "--up"),
    ],
)
def test_unknown_objects_are_refused_with_a_reason(words, error) -> None:
    with pytest.raises(InputError, match=error):
        scanned_object(**words, variant=0)


def test_meshes_that_can_not_stand_are_named(tmp_path: Path) -> None:
    flat = tmp_path / "flat.obj"
    flat.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3")
    with pytest.raises(CircumspectError, match=r"flat\.obj.*height"):
        scanned_object(str(flat), 0)
    (tmp_path / "broken.off").write_text("OFF\n3 1 0\n0 0")
    with pytest.raises(CircumspectError, match=r"broken\.off"):
        scanned_object(str(tmp_path / "broken.off"), 0)


def test_packs_that_are_missing_or_lack_the_object(packs: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="chair_9999"):
        scanned_object("chair_9999", 0, data=packs)
    with pytest.raises(InputError, match=r"no point packs .* nor <class>"):
        scanned_object("chair_0001", 0, data=tmp_path)
