"""Every format gives the shape that was written."""

from __future__ import annotations

import codecs
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shape_files
import trimesh

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud, read_cloud, read_mesh, write_ply
from circumspect.geometry.formats.cloud_files import READERS


def write_file(folder: Path, name: str, data: bytes) -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("name", shape_files.MESHES)
def test_meshes(name: str, tmp_path: Path):
    path = write_file(tmp_path, name, shape_files.MESHES[name]())
    mesh = read_mesh(path, up="z")
    assert mesh.areas.sum() == pytest.approx(shape_files.AREA, rel=1e-6)
    extent = np.ptp(mesh.vertices_xyz, axis=0)
    np.testing.assert_allclose(extent, [1, 2, 3], rtol=1e-6)
    cloud = read_cloud(path, samples=500)
    assert len(cloud) == 500
    assert cloud.normals_xyz is not None
    # All faces of a box are parallel to an axis.
    assert np.sort(np.abs(cloud.normals_xyz), axis=1)[:, 2] == pytest.approx(1)


@pytest.mark.parametrize(
    "name", ["plain.off", "binary.ply", "ascii.ply", "plain.obj", "binary.stl"]
)
def test_meshes_as_trimesh_reads_them(name: str, tmp_path: Path):
    path = write_file(tmp_path, name, shape_files.MESHES[name]())
    other = trimesh.load_mesh(path, process=False)
    mesh = read_mesh(path)
    np.testing.assert_allclose(mesh.corners_xyz, other.triangles, rtol=0, atol=1e-7)


@pytest.mark.parametrize("name", shape_files.CLOUDS)
def test_clouds_are_kept_point_by_point(name: str, tmp_path: Path):
    cloud = read_cloud(write_file(tmp_path, name, shape_files.CLOUDS[name]()), samples=7)
    np.testing.assert_array_equal(cloud.points_xyz, shape_files.POINTS)


@pytest.mark.parametrize(
    "name", [*(n for n in shape_files.CLOUDS if n.endswith(("pcd", "ply"))), "normals.npz"]
)
def test_normals_are_kept(name: str, tmp_path: Path):
    cloud = read_cloud(write_file(tmp_path, name, shape_files.CLOUDS[name]()))
    np.testing.assert_array_equal(cloud.normals_xyz, shape_files.NORMALS)


def test_every_reader_is_tested():
    names = [*shape_files.MESHES, *shape_files.CLOUDS]
    # Those of test_gltf and test_library_formats.
    elsewhere = {".gltf", ".las", ".laz", ".e57", ".usd", ".usda", ".usdc", ".usdz"}
    assert set(READERS) - {Path(name).suffix for name in names} == elsewhere


def test_gltf_with_a_scene_and_a_file_beside(tmp_path: Path):
    scene = trimesh.Scene()
    scene.add_geometry(shape_files.BOX)
    scene.add_geometry(
        shape_files.BOX, transform=trimesh.transformations.translation_matrix([9, 0, 0])
    )
    for name, data in scene.export(file_type="gltf").items():
        write_file(tmp_path, name, data)
    mesh = read_mesh(tmp_path / "model.gltf")
    assert mesh.areas.sum() == pytest.approx(2 * shape_files.AREA)
    np.testing.assert_allclose(np.ptp(mesh.vertices_xyz, axis=0), [10, 3, 2])


def test_glb_of_points(tmp_path: Path):
    scene = trimesh.Scene(trimesh.PointCloud(shape_files.POINTS))
    cloud = read_cloud(write_file(tmp_path, "points.glb", scene.export(file_type="glb")), up="z")
    np.testing.assert_array_equal(cloud.points_xyz, shape_files.POINTS)


def test_binary_stl_that_begins_with_solid(tmp_path: Path):
    data = shape_files.exported("stl")
    assert len(read_mesh(write_file(tmp_path, "a.stl", b"solid" + data[5:])).faces) == 12


@pytest.mark.parametrize("name", [b"", b"my vertex", b"vertex 1 2 3", b"Solid of a VERTEX facet"])
@pytest.mark.parametrize("newline", [b"\n", b"\r\n", b"\r", b" "])
def test_ascii_stl_may_have_any_name(name: bytes, newline: bytes, tmp_path: Path):
    """Also where all stands in one line."""
    data = shape_files.exported("stl_ascii")
    named = re.sub(rb"solid[^\n]*", b"solid " + name, data)
    assert named.count(name) >= 2
    mesh = read_mesh(write_file(tmp_path, "a.stl", named.replace(b"\n", newline)))
    plain = read_mesh(write_file(tmp_path, "b.stl", data))
    np.testing.assert_array_equal(mesh.corners_xyz, plain.corners_xyz)


@pytest.mark.parametrize("byte_order", ["", "<", ">"])
def test_a_ply_property_with_the_name_of_the_faces_list_may_be_a_number(
    byte_order: str, tmp_path: Path
):
    order = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[byte_order]
    header = (
        f"ply\nformat {order} 1.0\nelement vertex 50\nproperty double x\nproperty double y\n"
        "property double z\nelement face 1\nproperty int vertex_index\nend_header\n"
    ).encode()
    points = shape_files.POINTS
    body = shape_files.rows(points).encode() + b"7\n"
    if byte_order:
        body = points.astype(f"{byte_order}f8").tobytes() + np.int32(7).tobytes()
    cloud = read_cloud(write_file(tmp_path, "a.ply", header + body))
    np.testing.assert_array_equal(cloud.points_xyz, points)


@pytest.mark.parametrize("separator", [" ", ", ", ";"])
@pytest.mark.parametrize("mark", ["#", "//"])
def test_comments_may_stand_anywhere(mark: str, separator: str, tmp_path: Path):
    lines = shape_files.rows(shape_files.POINTS, separator).splitlines()
    lines[0] += f"{mark}first, of all"
    lines[3] += f" {mark} on the axis; nearly"
    lines[5:5] = [f"{mark} a new row", "", f"  {mark}"]
    data = "\n".join([f"{mark} 1 2 3", *lines]).encode()
    cloud = read_cloud(write_file(tmp_path, "a.xyz", data))
    np.testing.assert_array_equal(cloud.points_xyz, shape_files.POINTS)


@pytest.mark.parametrize("name", ["plain.xyz", "comma.csv", "title.txt", "cloud.obj"])
def test_a_byte_order_mark_takes_no_point(name: str, tmp_path: Path):
    data = codecs.BOM_UTF8 + shape_files.CLOUDS[name]()
    cloud = read_cloud(write_file(tmp_path, name, data))
    np.testing.assert_array_equal(cloud.points_xyz, shape_files.POINTS)


def test_a_byte_order_mark_before_off(tmp_path: Path):
    name = next(name for name in shape_files.MESHES if name.endswith(".off"))
    data = shape_files.MESHES[name]()
    plain, marked = (
        write_file(tmp_path, "a.off", data),
        write_file(tmp_path, "b.off", codecs.BOM_UTF8 + data),
    )
    np.testing.assert_array_equal(read_mesh(marked).vertices_xyz, read_mesh(plain).vertices_xyz)


@pytest.mark.parametrize("name", ["ascii.pcd", "ascii_cloud.ply"])
def test_empty_lines_between_points_do_not_count(name: str, tmp_path: Path):
    head, _, last = shape_files.CLOUDS[name]().rstrip().rpartition(b"\n")
    cloud = read_cloud(write_file(tmp_path, name, head + b"\n\n \n" + last + b"\n"))
    np.testing.assert_array_equal(cloud.points_xyz, shape_files.POINTS)


def test_content_wins_over_a_wrong_suffix(tmp_path: Path):
    path = write_file(tmp_path, "cloud.xyz", shape_files.CLOUDS["little_cloud.ply"]())
    np.testing.assert_array_equal(read_cloud(path).points_xyz, shape_files.POINTS)


def test_upper_case_suffix(tmp_path: Path):
    assert len(read_cloud(write_file(tmp_path, "A.XYZ", shape_files.CLOUDS["plain.xyz"]()))) == 50


def test_a_mesh_is_needed(tmp_path: Path):
    path = write_file(tmp_path, "cloud.ply", shape_files.CLOUDS["little_cloud.ply"]())
    with pytest.raises(GeometryError, match=r"cloud\.ply: has no faces"):
        read_mesh(path)


@pytest.mark.parametrize("name", list(shape_files.CLOUDS))
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_missing_points_are_dropped_and_counted_in_every_format(
    name: str,
    bad: float,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
):
    points = shape_files.POINTS.copy()
    points[2::5] = bad
    monkeypatch.setattr(shape_files, "POINTS", points)
    path = write_file(tmp_path, name, shape_files.CLOUDS[name]())
    cloud = read_cloud(path)
    np.testing.assert_array_equal(cloud.points_xyz, points[np.isfinite(points[:, 0])])
    assert "ignored 10 of 50 points that are NaN or infinite" in caplog.text
    monkeypatch.setattr(shape_files, "POINTS", points * np.nan)
    path = write_file(tmp_path, name, shape_files.CLOUDS[name]())
    with pytest.raises(GeometryError, match="all 50 points are invalid"):
        read_cloud(path)


def test_useless_normals_are_ignored(tmp_path: Path):
    normals = shape_files.NORMALS.copy()
    normals[3] = 0
    data = shape_files.saved(points=shape_files.POINTS, normals=normals)
    assert read_cloud(write_file(tmp_path, "a.npz", data)).normals_xyz is None
    data = shape_files.saved(points=shape_files.POINTS, normals=shape_files.NORMALS * 1e-200)
    cloud = read_cloud(write_file(tmp_path, "a.npz", data))
    np.testing.assert_allclose(cloud.normals_xyz, shape_files.NORMALS)


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_up_axis_becomes_z_by_a_proper_rotation(up: str, tmp_path: Path):
    basis = write_file(tmp_path, "basis.npy", shape_files.npy(np.eye(3)))
    rotation = read_cloud(basis, up=up).points_xyz.T
    np.testing.assert_allclose(rotation @ np.eye(3)["xyz".index(up)], [0, 0, 1])
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3))
    assert np.linalg.det(rotation) == pytest.approx(1)
    # The smallest such rotation: none for z, a quarter turn for the others.
    assert np.trace(rotation) == pytest.approx(3 if up == "z" else 1)


def test_up_axis_turns_normals_and_meshes_too(tmp_path: Path):
    data = shape_files.saved(points_xyz=shape_files.POINTS, normals_xyz=shape_files.NORMALS)
    cloud = read_cloud(write_file(tmp_path, "a.npz", data), up="y")
    x, y, z = shape_files.NORMALS.T
    np.testing.assert_array_equal(cloud.normals_xyz, np.stack([x, -z, y], axis=1))
    mesh = read_mesh(write_file(tmp_path, "a.off", shape_files.exported("off")), up="x")
    np.testing.assert_allclose(np.ptp(mesh.vertices_xyz, axis=0), [3, 2, 1])


def test_same_seed_same_points(tmp_path: Path):
    path = write_file(tmp_path, "a.off", shape_files.exported("off"))
    one, two, other = (read_cloud(path, samples=100, seed=seed).points_xyz for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, two)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("kind", ["off", "ply", "obj", "stl", "xyz", "npy"])
def test_any_scale_is_read(kind: str, scale: float, tmp_path: Path):
    path = tmp_path / f"a.{kind}"
    if kind in ("xyz", "npy"):
        points = shape_files.POINTS * scale
        path.write_bytes(
            shape_files.npy(points) if kind == "npy" else shape_files.rows(points).encode()
        )
        np.testing.assert_allclose(read_cloud(path).points_xyz, points, rtol=1e-12)
        return
    # OBJ and OFF are written with few digits by trimesh, so by hand here.
    vertices, faces = shape_files.VERTICES * scale, shape_files.FACES
    if kind == "off":
        lines = "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
        path.write_text(f"OFF\n8 12 0\n{shape_files.rows(vertices)}{lines}")
    elif kind == "obj":
        lines = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)
        path.write_text(
            "".join(f"v {v}\n" for v in shape_files.rows(vertices).splitlines()) + lines
        )
    else:
        path.write_bytes(trimesh.Trimesh(vertices, faces, process=False).export(file_type=kind))
    cloud = read_cloud(path, samples=2000)
    np.testing.assert_allclose(np.ptp(cloud.points_xyz, axis=0) / scale, [1, 2, 3], rtol=0.05)
    assert np.linalg.norm(cloud.normals_xyz, axis=1) == pytest.approx(1)


def test_ply_round_trip(tmp_path: Path):
    rng = np.random.default_rng(0)
    points = rng.normal(size=(100, 3)) * 1e6 + 1e9
    normals = rng.normal(size=(100, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    for cloud in (
        PointCloud(points),
        PointCloud(points, normals_xyz=normals),
        PointCloud(points, areas=rng.random(100), normals_xyz=normals),
    ):
        write_ply(tmp_path / "new" / "a.ply", cloud)
        again = read_cloud(tmp_path / "new" / "a.ply")
        np.testing.assert_array_equal(again.points_xyz, cloud.points_xyz)
        for one, other in ((again.areas, cloud.areas), (again.normals_xyz, cloud.normals_xyz)):
            assert (one is None) == (other is None)
            if one is not None:
                np.testing.assert_allclose(one, other, rtol=1e-15)
    other = trimesh.load(tmp_path / "new" / "a.ply")
    np.testing.assert_allclose(np.asarray(other.vertices), points, rtol=1e-6)


def test_own_readers_import_neither_trimesh_nor_scipy(tmp_path: Path):
    for name in (*shape_files.MESHES, *shape_files.CLOUDS):
        write_file(tmp_path, name, (shape_files.MESHES | shape_files.CLOUDS)[name]())
    program = (
        "import sys, pathlib, circumspect.geometry as g\n"
        "for p in sorted(pathlib.Path(sys.argv[1]).iterdir()): g.read_cloud(p)\n"
        "g.fill_surface(g.read_cloud(p))\n"
        "print(*(m for m in ('trimesh', 'scipy') if m in sys.modules))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, tmp_path], capture_output=True, text=True, check=True
    )
    assert (done.stdout.strip(), done.stderr) == ("", "")
