"""Untrusted meshes, clouds, grids and sets: bounded memory and time, one line."""

from __future__ import annotations

import base64
import io
import json
import os
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from little_memory import little_memory

from circumspect.classification import ExampleTable
from circumspect.datasets.gathered_set import MANIFEST, read_manifest, read_points
from circumspect.datasets.point_pack import read_point_pack
from circumspect.errors import InputError
from circumspect.geometry import read_cloud, read_mesh, read_tum
from circumspect.grid import CylindricalGrid, OccupancyGrid

ZEROS = 96 << 20
"""Bytes that the archives here unpack to, from a tenth of a megabyte."""


@pytest.fixture(scope="module")
def bomb() -> Callable[[str, str, tuple[int, ...]], bytes]:
    """A member of an archive: an array of zeros of that type and shape."""
    pad = bytes(1 << 20)

    def made(name: str, kind: str, shape: tuple[int, ...]) -> bytes:
        head = io.BytesIO()
        np.lib.format.write_array_header_1_0(
            head, {"descr": kind, "fortran_order": False, "shape": shape}
        )
        buffer = io.BytesIO()
        with (
            zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive,
            archive.open(f"{name}.npy", "w", force_zip64=True) as stream,
        ):
            stream.write(head.getvalue())
            for _ in range(ZEROS >> 20):
                stream.write(pad)
        return buffer.getvalue()

    return made


def with_members(data: bytes, **arrays: np.ndarray) -> bytes:
    buffer = io.BytesIO(data)
    with zipfile.ZipFile(buffer, "a") as archive:
        for name, array in arrays.items():
            held = io.BytesIO()
            np.lib.format.write_array(held, array, allow_pickle=False)
            archive.writestr(f"{name}.npy", held.getvalue())
    return buffer.getvalue()


def test_clouds_in_archives_do_not_explode(bomb, tmp_path):
    path = tmp_path / "a.npz"
    path.write_bytes(bomb("points_xyz", "<f8", (ZEROS // 24, 3)))
    assert path.stat().st_size < 1 << 20
    with (
        little_memory(48 << 20),
        pytest.raises(InputError, match=r"points_xyz would unpack from .* to 96 MiB"),
    ):
        read_cloud(path)


def test_archives_without_an_array_of_a_known_name_are_not_read_whole(tmp_path):
    """Each array may be as large as the limit for one; all of them took gigabytes."""
    path = tmp_path / "a.npz"
    zeros = {f"a{n}": np.zeros((100_000, 4)) for n in range(20)}
    np.savez_compressed(path, **zeros)
    with little_memory(16 << 20), pytest.raises(InputError, match="holds 0 arrays of shape"):
        read_cloud(path)
    points = np.random.default_rng(0).random((2000, 3))
    np.savez_compressed(path, **zeros, cloud=points)
    with little_memory(16 << 20):
        assert len(read_cloud(path)) == 2000


def test_a_trajectory_of_empty_lines(tmp_path):
    path = tmp_path / "a.tum"
    path.write_bytes(b"\n" * 1_000_000 + b"1 0 0 0 0 0 0 1\n")
    with little_memory(4 << 20):
        assert len(read_tum(path)) == 1


def test_packs_tables_and_gathered_clouds_do_not_explode(bomb, tmp_path):
    path = tmp_path / "train.npz"
    words = {"names": np.array(["a"]), "classes": np.array(["a"]), "labels": np.array([0])}
    numbers = {
        name: np.zeros(1, np.float32) for name in ("offset", "scale", "low", "step", "areas")
    }
    for name, kind, read in (
        ("points_u16", "<u2", read_point_pack),
        ("features_u8", "|u1", ExampleTable.load),
        ("points_xyz", "<f4", lambda p: read_points(p, "scan")),
    ):
        shape = (ZEROS // int(kind[2]) // 12, 4, 3)
        data = bomb(name, kind, shape)
        path.write_bytes(with_members(data, **words, **numbers, network=np.array(["x"])))
        with little_memory(48 << 20), pytest.raises(InputError, match="would unpack"):
            read(path)


def test_a_grid_does_not_explode(bomb, tmp_path):
    grid = CylindricalGrid((4, 4, 4)).hits(np.zeros((1, 3)))
    grid.save(tmp_path / "g.npz")
    with np.load(tmp_path / "g.npz") as stored:
        arrays = {name: stored[name] for name in stored.files if name != "occupied"}
    data = with_members(bomb("occupied", "|u1", (8,)), **arrays)
    (tmp_path / "g.npz").write_bytes(data)
    with (
        little_memory(48 << 20),
        pytest.raises(InputError, match=r"g\.npz: occupied has 9 bytes, not 8"),
    ):
        OccupancyGrid.load(tmp_path / "g.npz")


def test_a_compressed_pcd_does_not_explode(tmp_path):
    size = 1 << 28
    packed = bytes([224, 255, 0]) * (size // 264 + 1)
    header = (
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {size // 12}\nHEIGHT 1\nPOINTS {size // 12}\nDATA binary_compressed\n"
    )
    path = tmp_path / "a.pcd"
    path.write_bytes(header.encode() + struct.pack("<II", len(packed), size) + packed)
    with little_memory(48 << 20), pytest.raises(InputError, match="would unpack from"):
        read_cloud(path)


def test_headers_with_thousands_of_properties(tmp_path):
    properties = "".join(f"property int a{n}\n" for n in range(12_000))
    ply = f"ply\nformat ascii 1.0\nelement vertex 1\n{properties}end_header\n"
    (tmp_path / "a.ply").write_text(ply)
    long = ply.replace("element", "comment " + "x" * 300_000 + "\nelement")
    (tmp_path / "b.ply").write_text(long)
    names = " ".join(f"a{n}" for n in range(20_000))
    ones = "1 " * 20_000
    (tmp_path / "a.pcd").write_text(
        f"FIELDS {names}\nSIZE {ones}\nTYPE {'I ' * 20_000}\nWIDTH 1\nHEIGHT 1\nDATA binary\n"
    )
    with little_memory(seconds=3.0):
        for name, complaint in (
            ("a.ply", "500 elements"),
            ("b.ply", "header of"),
            ("a.pcd", "fields"),
        ):
            with pytest.raises(InputError, match=complaint):
                read_cloud(tmp_path / name)


def test_files_that_are_larger_than_any_object(tmp_path):
    for name in ("a.ply", "a.off", "a.npy", "a.stl"):
        with (tmp_path / name).open("wb") as stream:
            stream.write(b"ply\n")
            stream.truncate(2**40)
        with little_memory(48 << 20), pytest.raises(InputError, match="larger than 4 GiB"):
            read_cloud(tmp_path / name)


def test_a_trajectory_that_is_larger_than_any(tmp_path):
    with (tmp_path / "a.txt").open("wb") as stream:
        stream.truncate(2**40)
    with little_memory(48 << 20), pytest.raises(InputError, match="larger than 4 GiB"):
        read_tum(tmp_path / "a.txt")


def gltf(**changes) -> dict:
    triangle = np.eye(3, dtype="<f4").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(triangle).decode()
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(triangle), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": len(triangle)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    } | changes


def binary_tree(depth: int) -> list[dict]:
    """2 to the power of depth ways to the same mesh."""
    return [{"children": [n + 1, n + 1]} for n in range(depth)] + [{"mesh": 0}]


HOSTILE_SCENES = {
    "endless zeros": (
        gltf(accessors=[{"componentType": 5126, "count": 2**40, "type": "VEC3"}]), "announces"
    ),
    "the same part over and over": (gltf(nodes=binary_tree(40)), "a scene is a tree"),
    "a crowd": (
        gltf(nodes=[{"mesh": 0}] * 100, scenes=[{"nodes": [*range(100)]}],
             accessors=[{"bufferView": 0, "componentType": 5121, "count": 300_000, "type": "VEC3"}]),
        "shows 30000000 vertices",
    ),
    "many buffers": (gltf(buffers=[{"byteLength": 2**30, "uri": "a.gltf"}] * 1000), "1000 buffers"),
    "another file, escaped": (
        gltf(buffers=[{"byteLength": 36, "uri": "%2e%2e/secret.bin"}]), "outside of its folder"
    ),
    "zeros that a false size excuses": (
        gltf(buffers=[{"byteLength": 2**50}],
             accessors=[{"componentType": 5126, "count": 2**40, "type": "VEC3"}]), "announces"
    ),
    "a child before the first": (gltf(nodes=[{"mesh": 0, "children": [-1]}]), "entry -1 of nodes"),
    "a crowd of instances": (
        gltf(nodes=[{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"SCALE": 1}}}}],
             accessors=[{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                        {"componentType": 5126, "count": 5_000_000, "type": "VEC3"}]), "shows 5000000 instances"
    ),
    "a sparse value beyond the end": (
        gltf(accessors=[{"componentType": 5126, "count": 2, "type": "VEC3", "sparse": {
            "count": 1, "indices": {"bufferView": 0, "componentType": 5125, "byteOffset": 0},
            "values": {"bufferView": 0}}}]), "replaces value 1065353216 of 2"
    ),
    "a negative count": (gltf(accessors=[{"count": -5, "type": "VEC3"}]), "negative"),
    "another file": (gltf(buffers=[{"byteLength": 36, "uri": "../secret.bin"}]), "outside of its folder"),
    "a network": (gltf(buffers=[{"byteLength": 36, "uri": "http://[::1]/a"}]), "outside of its folder"),
    "a loop": (gltf(nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}]), "within itself"),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE_SCENES)
def test_untrusted_scenes_are_bounded(name, tmp_path):
    scene, complaint = HOSTILE_SCENES[name]
    (tmp_path / "secret.bin").write_bytes(np.eye(3, dtype="<f4").tobytes())
    folder = tmp_path / "scene"
    folder.mkdir()
    path = folder / "a.gltf"
    path.write_text(json.dumps(scene))
    with little_memory(48 << 20), pytest.raises(InputError, match=complaint) as error:
        read_mesh(path)
    assert "\n" not in str(error.value)


def test_a_scene_does_not_wait_for_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe.bin")
    scene = gltf(buffers=[{"byteLength": 36, "uri": "pipe.bin"}])
    (tmp_path / "a.gltf").write_text(json.dumps(scene))
    with pytest.raises(InputError, match="not a regular file"):
        read_cloud(tmp_path / "a.gltf")


def test_a_plain_scene_is_read(tmp_path):
    (tmp_path / "a.gltf").write_text(json.dumps(gltf()))
    assert len(read_mesh(tmp_path / "a.gltf").faces) == 1


@pytest.mark.parametrize("text", ["[" * 200_000, "{}", "[]", '{"accessors": 5}', '{"nodes": [[]]}'])
def test_headers_that_are_no_scene(text, tmp_path):
    (tmp_path / "a.gltf").write_text(text)
    with little_memory(48 << 20), pytest.raises(InputError, match=r"a\.gltf"):
        read_cloud(tmp_path / "a.gltf")


def test_untrusted_manifests_are_bounded(tmp_path):
    good = {"scan": "a", "object": "a", "label": "a", "split": "train", "start_deg": 0.0}
    for line in ("[" * 200_000, json.dumps({**good, "files": {"cloud": "/etc/passwd"}}),
                 json.dumps({**good, "files": {"cloud": "../../secret"}}),
                 json.dumps({**good, "__class__": "os.system"})):  # fmt: skip
        (tmp_path / MANIFEST).write_text(line + "\n")
        with pytest.raises(InputError, match="line 1"):
            read_manifest(tmp_path)


def test_no_pickle_is_ever_loaded(tmp_path):
    class Evil:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "run"),)

    np.save(tmp_path / "a.npy", np.array([Evil()], dtype=object), allow_pickle=True)
    np.savez(tmp_path / "a.npz", points_xyz=np.array([Evil()], dtype=object))
    for name in ("a.npy", "a.npz"):
        with pytest.raises(InputError):
            read_cloud(tmp_path / name)
    for read in (read_point_pack, ExampleTable.load, OccupancyGrid.load):
        with pytest.raises(InputError):
            read(Path(tmp_path / "a.npz"))
    assert not (tmp_path / "run").exists()
