"""Own classes in files of any readable format."""

import json

import numpy as np
import pytest
import trimesh

from circumspect.cli.main import main
from circumspect.datasets import open_data_set
from circumspect.datasets.own_verification import verify_own
from circumspect.datasets.point_pack import read_point_pack, write_point_pack
from circumspect.datasets.scan_sources import of_point_set
from circumspect.errors import InputError
from circumspect.geometry import write_ply

SIDES = {"plate": (0.4, 0.3, 0.05), "post": (0.1, 0.1, 0.8)}


def box(label, scale=1.0):
    return trimesh.creation.box(np.array(SIDES[label]) * scale)


def write(root, place, scale=1.0):
    """A plate or a post, by the suffix of its name."""
    file = root / place
    file.parent.mkdir(parents=True, exist_ok=True)
    mesh = box(file.parts[-3], scale)
    if file.suffix.lower() == ".ply" and "cloud" in file.stem:
        write_ply(file, trimesh.sample.sample_surface(mesh, 500, seed=0)[0])
    elif file.suffix.lower() in (".glb", ".gltf"):
        # y is up there.
        mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
        mesh.export(file)
    elif file.suffix == ".xyz":
        np.savetxt(file, trimesh.sample.sample_surface(mesh, 500, seed=0)[0])
    else:
        file.write_bytes(_exported(mesh, file.suffix[1:].lower()))
    return file


def _exported(mesh, kind):
    found = mesh.export(file_type=kind)
    return found.encode() if isinstance(found, str) else found


FORMATS = ["a.off", "b.PLY", "c.obj", "d.stl", "e.glb", "cloud_f.ply", "g.xyz"]


@pytest.fixture
def mixed(tmp_path):
    """Every format in both classes, and a material file beside the meshes."""
    for label in SIDES:
        for name in FORMATS:
            write(tmp_path, f"{label}/train/{name}")
        write(tmp_path, f"{label}/test/t.glb")
    (tmp_path / "plate" / "train" / "c.mtl").write_text("newmtl red")
    return tmp_path


def test_every_format_trains(mixed, tmp_path):
    objects = open_data_set(mixed, "train")
    assert objects.classes == ("plate", "post")
    assert len(objects) == 2 * len(FORMATS)
    assert objects.names[0] == "plate/train/a"
    for points, label in zip(objects.points_xyz, objects.labels, strict=True):
        found = np.ptp(points, axis=0)
        wanted = np.array(SIDES[objects.classes[label]])
        assert np.allclose(found / found.max(), wanted / wanted.max(), atol=0.1), "upright"


def test_sizes_are_kept_where_the_format_has_metres(mixed, tmp_path):
    objects = open_data_set(mixed, "train")
    metric = [name.endswith("/e") for name in objects.names.tolist()]
    assert objects.metric.tolist() == metric
    assert objects.sides[metric] == pytest.approx([0.4, 0.8])
    write_point_pack(tmp_path / "kept.npz", objects)
    assert read_point_pack(tmp_path / "kept.npz").metric.tolist() == metric
    known = objects.subset(np.array(metric))
    surfaces = of_point_set(known)
    assert np.ptp(surfaces.mesh(1).vertices_xyz, axis=0).max() == pytest.approx(0.8, rel=0.01)
    assert surfaces.size_factors(0) == (1.0, 1.0)
    with pytest.raises(InputError, match=r"no sizes are known for plate, post; .*GLB"):
        of_point_set(objects)


def test_sizes_are_part_of_what_scans_are_made_of(tmp_path):
    digests = []
    for scale in (1.0, 2.0):
        write(tmp_path, "plate/train/a.glb", scale)
        digests.append(of_point_set(open_data_set(tmp_path, "train")).digest)
    assert digests[0] != digests[1]


def test_verify_counts_every_format(mixed, capsys):
    assert main(["data", "verify", str(mixed), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["counts"]["train"] == {"plate": len(FORMATS), "post": len(FORMATS)}
    assert document["missing"] == document["foreign"] == document["broken"] == []


def test_one_object_in_two_files_is_named(tmp_path):
    for name in ("a.obj", "a.ply"):
        write(tmp_path, f"plate/train/{name}")
    with pytest.raises(InputError, match=r"a\.obj and .*a\.ply: one object in two files; remove"):
        open_data_set(tmp_path, "train")
    found = verify_own(tmp_path)
    assert [file for file, _ in found.broken] == ["plate/train/a.ply"]


def test_test_file_of_a_training_files_name_is_another_object(tmp_path):
    write(tmp_path, "plate/train/plate_0001.obj")
    write(tmp_path, "plate/test/plate_0001.glb")
    assert open_data_set(tmp_path, "train").names.tolist() == ["plate_0001"]
    assert open_data_set(tmp_path, "test").names.tolist() == ["plate/test/plate_0001"]


def test_points_that_span_no_shape_are_named(tmp_path, capsys):
    write(tmp_path, "plate/train/a.obj")
    line = tmp_path / "plate" / "train" / "b.xyz"
    np.savetxt(line, np.outer(np.arange(20.0), [1, 0, 0]))
    with pytest.raises(InputError, match=r"b\.xyz: "):
        open_data_set(tmp_path, "train")
    assert main(["data", "verify", str(tmp_path)]) == 1
    assert "b.xyz" in capsys.readouterr().out


def test_scan_of_an_object_of_an_own_set_has_its_size(tmp_path):
    from circumspect.gathering.scanned_object import scanned_object

    write(tmp_path, "post/test/p.glb")
    found = scanned_object("post/test/p", 0, None, None, tmp_path)
    assert found.label == "post"
    assert np.ptp(found.mesh.vertices_xyz, axis=0)[2] == pytest.approx(0.8, rel=0.01)
