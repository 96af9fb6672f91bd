"""glTF 2.0: what its specification and its common extensions say about geometry is honoured."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry import read_cloud, read_mesh
from circumspect.geometry.formats import gltf_primitives
from circumspect.geometry.formats.polygons import fan_of, strip_triangles

CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
"""Corners; that of index 7 is (1, 1, 1)."""
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5]], np.uint16)
"""Two of its sides, which are one unit apart: x = 0 and x = 1."""


class Builder:
    """Collects arrays into one buffer, and writes a file with them."""

    def __init__(self) -> None:
        self.content = b""
        self.header: dict[str, Any] = {"asset": {"version": "2.0"}, "accessors": []}
        self.views: list[dict[str, Any]] = []

    def view(self, content: bytes, **changes: Any) -> int:
        self.content += bytes(-len(self.content) % 4)
        self.views.append(
            {"buffer": 0, "byteOffset": len(self.content), "byteLength": len(content)} | changes
        )
        self.content += content
        return len(self.views) - 1

    def accessor(self, array: np.ndarray, **changes: Any) -> int:
        array = array.reshape(len(array), -1)
        entry = {
            "bufferView": self.view(array.tobytes()), "count": len(array),
            "componentType": CODES[array.dtype.str[1:]], "type": TYPES[array.shape[1]],
        }  # fmt: skip
        self.header["accessors"].append(entry | changes)
        return len(self.header["accessors"]) - 1

    def mesh(self, points: np.ndarray, indices: np.ndarray | None, **part: Any) -> None:
        """Another mesh of one primitive."""
        primitive: dict[str, Any] = {"attributes": {"POSITION": self.accessor(points)}}
        if indices is not None:
            primitive["indices"] = self.accessor(indices.reshape(-1))
        self.header.setdefault("meshes", []).append({"primitives": [primitive | part]})

    def save(self, folder: Path, uri: str | None = None, **header: Any) -> Path:
        path = folder / "a.gltf"
        data = "data:application/octet-stream;base64," + base64.b64encode(self.content).decode()
        buffers = [{"byteLength": len(self.content), "uri": uri or data}]
        path.write_text(
            json.dumps({**self.header, "bufferViews": self.views, "buffers": buffers, **header})
        )
        return path


@pytest.fixture
def cube() -> Builder:
    builder = Builder()
    builder.mesh(CUBE, FACES)
    builder.header |= {"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0}
    return builder


def corners(path: Path) -> np.ndarray:
    """(f, 3, 3) corners in the axes of the file."""
    return read_mesh(path, up="z").corners_xyz


EXPECTED = CUBE[FACES.astype(int)]


def test_y_is_up_by_default_and_z_by_request(cube: Builder, tmp_path: Path):
    path = cube.save(tmp_path)
    x, y, z = EXPECTED.reshape(-1, 3).T
    turned = np.stack([x, -z, y], axis=1).reshape(-1, 3, 3)
    np.testing.assert_array_equal(read_mesh(path).corners_xyz, turned)
    np.testing.assert_array_equal(read_mesh(path, up="y").corners_xyz, turned)
    np.testing.assert_array_equal(corners(path), EXPECTED)
    assert np.ptp(read_cloud(path, samples=50).points_xyz[:, 2]) > 0.5


def test_sparse_values_replace_those_of_the_view_or_zeros(cube: Builder, tmp_path: Path):
    rows, values = np.array([1, 7], np.uint16), np.array([[5, 5, 5], [6, 6, 6]], np.float32)
    sparse = {
        "count": 2,
        "indices": {"bufferView": cube.view(rows.tobytes()), "componentType": CODES["u2"]},
        "values": {"bufferView": cube.view(values.tobytes())},
    }
    cube.header["accessors"][0]["sparse"] = sparse
    points = CUBE.copy()
    points[rows] = values
    np.testing.assert_array_equal(corners(cube.save(tmp_path)), points[FACES.astype(int)])
    del cube.header["accessors"][0]["bufferView"]
    points[~np.isin(np.arange(8), rows)] = 0
    np.testing.assert_array_equal(corners(cube.save(tmp_path)), points[FACES.astype(int)])


@pytest.mark.parametrize(
    ("kind", "largest"), [("i1", 127), ("u1", 255), ("i2", 32767), ("u2", 65535)]
)
def test_quantised_integers_are_shares_where_they_are_normalised(
    kind: str, largest: int, tmp_path: Path
):
    for normalized, scale in ((True, 1.0), (False, 1.0 / largest)):
        builder = Builder()
        builder.mesh((CUBE * largest).astype(kind), FACES)
        builder.header["accessors"][0]["normalized"] = normalized
        builder.header["nodes"] = [{"mesh": 0, "scale": [scale] * 3}]
        path = builder.save(tmp_path, extensionsRequired=["KHR_mesh_quantization"])
        np.testing.assert_allclose(corners(path), EXPECTED, atol=1e-12)


def test_strided_vertices_are_read(tmp_path: Path):
    builder = Builder()
    table = np.zeros(8, [("normal", "<f4", 3), ("position", "<f4", 3)])
    table["position"] = CUBE
    builder.header["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    builder.header["accessors"] = [
        {"bufferView": builder.view(table.tobytes(), byteStride=24), "byteOffset": 12, "count": 8,
         "componentType": 5126, "type": "VEC3"},
    ]  # fmt: skip
    builder.accessor(FACES.reshape(-1))
    np.testing.assert_array_equal(corners(builder.save(tmp_path)), EXPECTED)


@pytest.mark.parametrize("mode", [5, 6])
def test_strips_and_fans_make_the_triangles_of_a_list(mode: int, tmp_path: Path):
    """A square of four corners."""
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], np.float32)
    order = np.array([0, 1, 2, 3] if mode == 5 else [0, 1, 3, 2], np.uint8)
    for indices in (order, None):
        builder = Builder()
        points = square if indices is not None else square[order.astype(int)]
        builder.mesh(points, indices, mode=mode)
        mesh = read_mesh(builder.save(tmp_path), up="z")
        assert mesh.areas.sum() == pytest.approx(1.0)
        a, b, c = np.moveaxis(mesh.corners_xyz, 1, 0)
        assert (np.cross(b - a, c - a)[:, 2] > 0).all()


@given(st.lists(st.integers(0, 5), max_size=12))
def test_a_strip_is_that_of_every_three_neighbours(indices: list[int]):
    triangles = strip_triangles(np.array(indices, np.int64))
    expected = [
        tuple(t if n % 2 == 0 else (t[1], t[0], t[2]))
        for n, t in enumerate(zip(indices, indices[1:], indices[2:], strict=False))
        if len(set(t)) == 3
    ]
    assert list(map(tuple, triangles.tolist())) == expected
    assert len(fan_of(np.array(indices, np.int64))) == max(0, len(indices) - 2)


@given(st.lists(st.lists(st.integers(0, 5), max_size=6), max_size=4))
def test_a_restart_begins_another_strip(strips: list[list[int]]):
    joined = [index for strip in strips for index in [*strip, -1]]
    apart = [row for strip in strips for row in strip_triangles(np.array(strip, int)).tolist()]
    assert strip_triangles(np.array(joined, int), restart=-1).tolist() == apart


def test_lines_are_no_surface_and_unknown_modes_are_refused(cube: Builder, tmp_path: Path):
    part = cube.header["meshes"][0]["primitives"][0]
    cube.header["meshes"][0]["primitives"] = [{**part, "mode": 1}, part]
    np.testing.assert_array_equal(corners(cube.save(tmp_path)), EXPECTED)
    part["mode"] = 9
    with pytest.raises(InputError, match="primitive of the unknown mode 9"):
        read_mesh(cube.save(tmp_path))


def test_nodes_move_turn_and_scale_their_children(cube: Builder, tmp_path: Path):
    rotation = Rotation.from_rotvec([0.3, -0.2, 0.9])
    matrix = np.eye(4)
    matrix[:3] = [[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 2, 7]]
    cube.header["nodes"] = [
        {"children": [1], "matrix": matrix.T.reshape(-1).tolist()},
        {"mesh": 0, "translation": [1, 2, 3], "scale": [2, 3, 4],
         "rotation": rotation.as_quat().tolist()},
    ]  # fmt: skip
    moved = rotation.apply(CUBE * [2, 3, 4]) + np.array([1, 2, 3])
    moved = moved @ matrix[:3, :3].T + matrix[:3, 3]
    np.testing.assert_allclose(corners(cube.save(tmp_path)), moved[FACES.astype(int)], atol=1e-6)


def test_instances_stand_at_their_places(cube: Builder, tmp_path: Path):
    places = np.array([[0, 0, 0], [10, 0, 0], [0, 20, 0]], np.float32)
    turns = Rotation.from_rotvec([[0, 0, 0], [0, 1, 0], [0, 0, 2]])
    attributes = {
        "TRANSLATION": cube.accessor(places),
        "ROTATION": cube.accessor(turns.as_quat().astype(np.float32)),
    }
    extension = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    cube.header["nodes"][0] |= {"extensions": extension, "translation": [0, 0, 100]}
    path = cube.save(tmp_path, extensionsRequired=["EXT_mesh_gpu_instancing"])
    expected = np.concatenate(
        [turn.apply(CUBE)[FACES.astype(int)] + place + [0, 0, 100]
         for turn, place in zip(turns, places, strict=True)]
    )  # fmt: skip
    np.testing.assert_allclose(corners(path), expected, atol=1e-5)


def test_invisible_nodes_are_left_out(cube: Builder, tmp_path: Path):
    hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}, "children": [1]}
    cube.header |= {"nodes": [hidden, {"mesh": 0}, {"mesh": 0}], "scenes": [{"nodes": [0, 2]}]}
    path = cube.save(tmp_path, extensionsRequired=["KHR_node_visibility"])
    assert len(corners(path)) == len(FACES)


@pytest.mark.parametrize("missing", [("scenes", "scene"), ("scene",), ("scenes", "scene", "nodes")])
def test_files_without_scenes_show_all(missing: tuple[str, ...], cube: Builder, tmp_path: Path):
    for name in missing:
        del cube.header[name]
    np.testing.assert_array_equal(corners(cube.save(tmp_path)), EXPECTED)


@pytest.mark.parametrize(
    ("file", "uri"),
    [("my chair.bin", "my%20chair.bin"), ("stühle.bin", "st%C3%BChle.bin"), ("a%20b.bin", "a%20b.bin"),
     ("parts/a.bin", "parts/a.bin"), ("my chair.bin", "my chair.bin")],
)  # fmt: skip
def test_uris_are_decoded(file: str, uri: str, cube: Builder, tmp_path: Path):
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_bytes(cube.content)
    np.testing.assert_array_equal(corners(cube.save(tmp_path, uri)), EXPECTED)


def test_a_missing_buffer_is_named(cube: Builder, tmp_path: Path):
    with pytest.raises(
        InputError, match=r"a\.gltf: needs my chair\.bin, which does not lie beside"
    ):
        read_mesh(cube.save(tmp_path, "my%20chair.bin"))


@pytest.mark.parametrize("version", ["1.0", "1.1", "3.0"])
def test_other_versions_are_named(version: str, cube: Builder, tmp_path: Path):
    with pytest.raises(InputError, match=f"is glTF {version}, and only glTF 2.0 is read"):
        read_mesh(cube.save(tmp_path, asset={"version": version}))


@pytest.mark.parametrize("name", ["KHR_materials_clearcoat", "EXT_texture_webp"])
def test_required_extensions_without_geometry_do_not_matter(
    name: str, cube: Builder, tmp_path: Path
):
    np.testing.assert_array_equal(corners(cube.save(tmp_path, extensionsRequired=[name])), EXPECTED)


@pytest.mark.parametrize(
    ("name", "remedy"),
    [("ACME_spheres", "export it without"), ("EXT_meshopt_compression", "gltf-transform copy")],
)
def test_other_required_extensions_are_refused_by_name(
    name: str, remedy: str, cube: Builder, tmp_path: Path
):
    with pytest.raises(InputError, match=rf"{name}, which is not read; .*{remedy}"):
        read_mesh(cube.save(tmp_path, extensionsRequired=["KHR_mesh_quantization", name]))


def test_a_hollow_buffer_of_meshopt_is_not_read_as_zeros(cube: Builder, tmp_path: Path):
    extension = {"EXT_meshopt_compression": {"buffer": 0}}
    cube.views[0]["extensions"] = extension
    # With a real fallback the extension may be passed over.
    np.testing.assert_array_equal(corners(cube.save(tmp_path)), EXPECTED)
    path = cube.save(tmp_path)
    header = json.loads(path.read_text())
    header["buffers"][0]["extensions"] = {"EXT_meshopt_compression": {"fallback": True}}
    path.write_text(json.dumps(header))
    with pytest.raises(InputError, match="compressed by EXT_meshopt_compression"):
        read_mesh(path)


def with_draco(folder: Path) -> Path:
    """The two sides of the cube, compressed."""
    coder = pytest.importorskip("DracoPy")
    builder = Builder()
    view = builder.view(coder.encode(CUBE, FACES.astype(np.uint32), quantization_bits=14))
    builder.header["accessors"] = [
        {"componentType": 5126, "count": 8, "type": "VEC3"},
        {"componentType": 5123, "count": 12, "type": "SCALAR"},
    ]
    extension = {"bufferView": view, "attributes": {"POSITION": 0}}
    part = {
        "attributes": {"POSITION": 0}, "indices": 1,
        "extensions": {"KHR_draco_mesh_compression": extension},
    }  # fmt: skip
    builder.header["meshes"] = [{"primitives": [part]}]
    return builder.save(folder, extensionsRequired=["KHR_draco_mesh_compression"])


def test_draco_is_decoded(tmp_path: Path):
    mesh = read_mesh(with_draco(tmp_path), up="z")
    assert mesh.areas.sum() == pytest.approx(2.0, rel=1e-3)
    np.testing.assert_allclose(np.ptp(mesh.vertices_xyz, axis=0), 1, atol=1e-3)


def test_draco_without_its_decoder_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = with_draco(tmp_path)
    monkeypatch.setitem(__import__("sys").modules, "DracoPy", None)
    with pytest.raises(MissingExtraError, match=r"circumspect\[formats\]"):
        read_mesh(path)


@pytest.mark.parametrize("data", [b"", b"DRACO", b"DRACO\x02\x02\x01\x01\0\0" + bytes(40)])
def test_broken_draco_is_refused(data: bytes):
    pytest.importorskip("DracoPy")
    with pytest.raises(InputError, match="broken Draco data"):
        gltf_primitives.decode_draco(data, 0)


def test_many_primitives_may_share_one_table_of_vertices(tmp_path: Path):
    builder = Builder()
    table = np.concatenate([CUBE, np.random.default_rng(0).random((5000, 3), np.float32)])
    builder.mesh(table, FACES[:1])
    first = builder.header["meshes"][0]["primitives"][0]
    parts = [{**first, "indices": builder.accessor(FACES[1:].reshape(-1))}, *[first] * 500]
    builder.header["meshes"][0]["primitives"] = parts
    mesh = read_mesh(builder.save(tmp_path))
    assert len(mesh.vertices_xyz) < 2000


@pytest.mark.parametrize(
    "change",
    [
        {"nodes": [{"mesh": 3}]}, {"nodes": [{"mesh": -1}]}, {"nodes": [{"mesh": "0"}]},
        {"nodes": [{"mesh": 0, "scale": [1, 2]}]}, {"nodes": [{"mesh": 0, "rotation": [0] * 4}]},
        {"nodes": 5}, {"scenes": [{"nodes": [7]}]}, {"scene": 4}, {"scene": -1},
        {"bufferViews": []}, {"accessors": []}, {"extensionsRequired": "all"},
    ],
)  # fmt: skip
def test_entries_that_do_not_fit_are_one_line(change: dict, cube: Builder, tmp_path: Path):
    path = cube.save(tmp_path)
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(InputError, match=r"a\.gltf: ") as error:
        read_mesh(path)
    assert "\n" not in str(error.value)


def test_indices_beyond_the_vertices_are_refused(tmp_path: Path):
    builder = Builder()
    builder.mesh(CUBE, np.array([[0, 1, 8]], np.uint16))
    with pytest.raises(InputError, match="a face names vertex 8, but the vertices are 0 … 7"):
        read_mesh(builder.save(tmp_path))
