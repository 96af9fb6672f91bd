"""Files that can not be read: one line that names the file and the remedy, in little memory."""

from __future__ import annotations

import os
import resource
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shape_files

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import read_cloud, read_mesh
from circumspect.geometry.formats.cloud_files import READERS

HUGE = 10**12
TABLES = ("obj", "xyz", "txt", "csv", "asc")
FILES = shape_files.MESHES | shape_files.CLOUDS


@pytest.fixture
def refused(tmp_path: Path) -> Callable[..., str]:
    """Give the one-line message with which a file of these bytes is refused."""

    def message(name: str, data: bytes, kind: type[InputError] = InputError) -> str:
        path = tmp_path / name
        path.write_bytes(data)
        with pytest.raises(kind) as error:
            read_cloud(path)
        text = str(error.value)
        assert text.startswith(f"{path}: ")
        assert text.isprintable()
        return text.removeprefix(f"{path}: ")

    return message


@pytest.mark.parametrize("suffix", READERS)
def test_empty(suffix: str, refused: Callable[..., str]):
    assert "is empty" in refused(f"a{suffix}", b"")


@pytest.mark.parametrize("suffix", READERS)
def test_blank(suffix: str, refused: Callable[..., str]):
    assert refused(f"a{suffix}", b" \n \n")


@pytest.mark.parametrize("suffix", [".xyz", ".csv", ".off", ".obj", ".ply", ".pcd"])
@pytest.mark.parametrize("order", ["utf-16-le", "utf-16-be"])
def test_text_in_utf_16(suffix: str, order: str, refused: Callable[..., str]):
    """The fault is the encoding, not the numbers."""
    text = "\ufeff0 0 0\n1 0 0\n0 1 0\n".encode(order)
    assert refused(f"a{suffix}", text) == "is text in UTF-16; save it as UTF-8 or ASCII"


@pytest.mark.parametrize("name", [name for name in FILES if not name.endswith(TABLES)])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_truncated(name: str, share: float, refused: Callable[..., str]):
    """A truncated file is no smaller object. (Formats without any count can not detect it.)"""
    data = FILES[name]()
    assert refused(name, data[: int(share * len(data))])


@pytest.mark.parametrize("name", ["a.jpg", "a", "a.ply.bak", ".ply"])
def test_unknown_format_lists_the_known(name: str, refused: Callable[..., str]):
    text = refused(name, b"\x01\x02\x03")
    assert "unknown format" in text
    assert all(suffix in text for suffix in READERS)


def test_missing_file_suggests_near_names(tmp_path: Path):
    (tmp_path / "chair_0001.off").touch()
    with pytest.raises(
        InputError, match=r"chiar_0001\.off: does not exist; near it: chair_0001\.off"
    ):
        read_cloud(tmp_path / "chiar_0001.off")
    with pytest.raises(InputError, match=r"zzz\.ply: does not exist; check the path"):
        read_cloud(tmp_path / "zzz.ply")
    with pytest.raises(InputError, match="does not exist, and the folder"):
        read_cloud(tmp_path / "nowhere" / "chair.off")


def test_a_dangling_link_names_its_target(tmp_path: Path):
    (tmp_path / "chair.ply").symlink_to("gone.ply")
    with pytest.raises(InputError) as caught:
        read_cloud(tmp_path / "chair.ply")
    reported = f"{tmp_path / 'chair.ply'}: is a link to gone.ply, which does not exist"
    assert str(caught.value) == reported


def test_folder(tmp_path: Path):
    with pytest.raises(InputError, match="is a folder; name a file in it"):
        read_cloud(tmp_path)


def test_device_and_pipe(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe.ply")
    for path in ("/dev/null", tmp_path / "pipe.ply"):
        with pytest.raises(InputError, match="not a regular file"):
            read_cloud(path)


def test_unusual_paths(tmp_path: Path):
    for name in ("a\nb.ply", "a" * 300 + ".ply", "a\0b.ply", os.fsdecode(b"\xff.ply")):
        with pytest.raises(InputError) as error:
            read_cloud(tmp_path / name)
        assert str(error.value).isprintable()


def test_no_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "a.ply"
    path.write_bytes(b"ply\n")

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(InputError, match=r"a\.ply: can not be read \(permission denied\)"):
        read_cloud(path)


def test_memory_errors_are_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def fail(_: Path) -> None:
        raise MemoryError

    path = tmp_path / "a.off"
    path.write_bytes(shape_files.exported("off"))
    monkeypatch.setitem(READERS, ".off", fail)
    with pytest.raises(InputError, match="does not fit into memory"):
        read_cloud(path)


@pytest.mark.parametrize("up", ["", "w", "Z", "-z"])
def test_unknown_axis(up: str):
    with pytest.raises(InputError, match="up must be x, y or z"):
        read_cloud("a.ply", up=up)


def test_no_samples():
    with pytest.raises(InputError, match="samples must be at least 1"):
        read_cloud("a.ply", samples=0)


def ply(vertices: object, faces: object, rows: bytes = b"", order: str = "ascii") -> bytes:
    return (
        f"ply\nformat {order} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {faces}\nproperty list uint int vertex_indices\nend_header\n"
    ).encode() + rows


def npy_header(text: str) -> bytes:
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode("latin-1")


TRIANGLE = b"0 0 0\n1 0 0\n0 1 0\n"
PACKED_TRIANGLE = np.eye(3, dtype="<f4").tobytes()


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.off", f"OFF\n{HUGE} 1 0\n".encode() + TRIANGLE),
        ("a.off", f"OFF\n3 {HUGE} 0\n".encode() + TRIANGLE),
        ("a.off", b"OFF\n3 1 0\n" + TRIANGLE + f"{HUGE} 0 1 2\n".encode()),
        ("a.ply", ply(HUGE, 0, TRIANGLE)),
        ("a.ply", ply(3, HUGE, TRIANGLE)),
        ("a.ply", ply(3, 1, TRIANGLE + f"{HUGE} 0 1 2\n".encode())),
        ("a.ply", ply(HUGE, 0, PACKED_TRIANGLE, "binary_little_endian")),
        ("a.ply", ply(3, HUGE, PACKED_TRIANGLE + bytes(99), "binary_little_endian")),
        (
            "a.ply",
            ply(3, 1, PACKED_TRIANGLE + b"\xff\xff\xff\xff" + bytes(12), "binary_big_endian"),
        ),
        ("a.stl", bytes(80) + b"\xff\xff\xff\xff" + bytes(100)),
        ("a.pcd", shape_files.pcd_header("ascii", HUGE) + b"0 0 0\n"),
        ("a.pcd", shape_files.pcd_header("binary", HUGE) + bytes(999)),
        (
            "a.pcd",
            shape_files.pcd_header("binary_compressed") + b"\x09\0\0\0\xff\xff\xff\xff" + bytes(9),
        ),
        (
            "a.npy",
            npy_header(f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({HUGE}, 3)}}")
            + bytes(99),
        ),
        ("a.obj", b"v 0 0 0\n" * 3 + f"f 1 2 {HUGE}\n".encode()),
    ],
)
def test_wrong_counts_allocate_no_memory(name: str, data: bytes, refused: Callable[..., str]):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    limits = resource.getrlimit(resource.RLIMIT_AS)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    try:
        resource.setrlimit(resource.RLIMIT_AS, (size + 200_000_000, limits[1]))
        text = refused(name, data)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)
    assert "memory" not in text
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # kB


@pytest.mark.parametrize(
    ("name", "data", "word"),
    [
        ("a.off", b"hello", "begin with OFF"),
        ("a.off", b"OFF BINARY\n\0\0", "binary OFF"),
        ("a.off", b"OFF\n3 1\n", "ends too early"),
        ("a.off", b"OFF\n3 x 0\n", "no counts"),
        ("a.off", b"OFF\n-3 1 0\n", "negative"),
        ("a.off", b"OFF\n3 1 0\n" + TRIANGLE + b"3 0 1 \xff\n", "broken"),
        ("a.off", b"OFF\n3 2 0\n" + TRIANGLE + b"4 0 1 2\n3 0 1 2\n", "4 corners that names 3"),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "broken table"),
        ("a.ply", b"hello", "begin with ply"),
        ("a.ply", b"ply\nformat ascii 1.0\n", "header has no end"),
        ("a.ply", b"ply\nformat klingon 1.0\nend_header\n", "broken header"),
        ("a.ply", b"ply\nelement vertex 1\nend_header\n", "broken header"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "negative count"),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header\n", "without vertices"),
        ("a.pcd", b"hello", "not a PCD"),
        (
            "a.pcd",
            b"FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 1\nDATA ascii\n1 2\n",
            "no fields x y z",
        ),
        ("a.pcd", b"FIELDS x\nSIZE 3\nTYPE F\nPOINTS 1\nDATA ascii\n1\n", "broken header"),
        (
            "a.pcd",
            b"FIELDS x y z\nSIZE 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1\n",
            "broken header",
        ),
        ("a.pcd", shape_files.pcd_header("zip") + b"\0", "unknown data 'zip'"),
        ("a.stl", b"hello", "not an STL"),
        ("a.stl", b"solid a\nfacet\nvertex 0 0 0\nendsolid\n", "three vertices"),
        ("a.stl", b"solid a\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 x 0\nendsolid\n", "broken table"),
        ("a.obj", b"hello", "not an OBJ"),
        ("a.obj", b"v 0 0\n", "broken table"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 three\n", "broken"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 " + b"9" * 400, "broken face"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -" + b"9" * 400, "broken face"),
        ("a.xyz", b"hello\nworld\n", "no line of three numbers"),
        ("a.xyz", b"1 2 3\n4 5\n", "broken table"),
        ("a.xyz", b"1 2 3\n4 x 6\n", "'x'"),
        ("a.xyz", b"1 2 3\n4 5 / 6\n", "'/'"),
        ("a.csv", b"1,2\n3,4\n", "no line of three numbers"),
        ("a.npy", b"\x93NUMPY", "NPY"),
        ("a.npy", shape_files.npy(np.zeros(3)), "shape (n, 3) or wider, not (3,)"),
        ("a.npy", shape_files.npy(np.zeros((3, 2))), "not (3, 2)"),
        (
            "a.npy",
            shape_files.npy(np.zeros((3, 20_000))),
            "has shape (3, 20000); points are rows: save its transpose",
        ),
        ("a.npy", shape_files.npy(np.zeros((48, 65))), "has shape (48, 65); a row is a point"),
        ("a.npz", shape_files.saved(depth_m=np.zeros((48, 3)), points=np.ones((48, 65))), "image"),
        ("a.npz", shape_files.saved(points=np.zeros((3, 17))), "points has shape (3, 17); points"),
        ("a.npy", shape_files.npy(np.zeros((3, 3), complex)), "complex128"),
        ("a.npy", shape_files.npy(np.array([["a", "b", "c"]])), "not of numbers"),
        ("a.npz", shape_files.saved(points=np.array([["a", "b", "c"]])), "not of numbers"),
        ("a.npz", shape_files.saved(), "no arrays"),
        (
            "a.npz",
            shape_files.saved(a=np.zeros((4, 3)), b=np.zeros((4, 3))),
            "2 arrays of shape (n, 3)",
        ),
        ("a.npz", b"PK\x03\x04hello", "NPZ"),
        ("a.glb", b"glTF\x02\0\0\0\xff\xff\xff\xff", "a GLB file without its header"),
        ("a.glb", b"glTF\x01\0\0\0\xff\xff\xff\xff", "is glTF 1.0, and only glTF 2.0 is read"),
        ("a.ptx", b"2\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n", "header of ten lines"),
        ("a.ptx", shape_files.ptx(shape_files.POINTS)[:-40], "ends too early"),
        (
            "a.npy",
            npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (True, 3)}") + bytes(24),
            "shape (True, 3) is not of whole numbers",
        ),
        (
            "a.stl",
            b"solid a\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1,5 0\nendsolid\n",
            "decimal points in place of commas",
        ),
        ("a.off", b"4nOFF\n3\n3 1 0\n" + TRIANGLE + b"3 0 1 2\n", "nOFF file of any dimension"),
        ("a.gltf", b"{}", "neither faces nor points"),
        ("a.gltf", b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "missing.bin"}]}', ""),
    ],
)
def test_broken(name: str, data: bytes, word: str, refused: Callable[..., str]):
    assert word in refused(name, data)


def test_object_arrays_are_never_unpickled(tmp_path: Path, refused: Callable[..., str]):
    class Bomb:
        def __reduce__(self) -> tuple:
            return (Path.touch, (tmp_path / "exploded",))

    array = np.array([[Bomb()] * 3], dtype=object)
    np.save(tmp_path / "bomb.npy", array, allow_pickle=True)
    np.savez(tmp_path / "bomb.npz", points=array, allow_pickle=True)
    for name in ("bomb.npy", "bomb.npz"):
        assert "object" in refused(name, (tmp_path / name).read_bytes())
    assert not (tmp_path / "exploded").exists()


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_unsupported_zip_methods(method: int, tmp_path: Path, refused: Callable[..., str]):
    with zipfile.ZipFile(tmp_path / "other.zip", "w", method) as archive:
        archive.writestr("points.npy", shape_files.npy(shape_files.POINTS))
    assert "packed in a way" in refused("a.npz", (tmp_path / "other.zip").read_bytes())


@pytest.mark.parametrize("index", [3, -1, 1.5, "nan", 99])
@pytest.mark.parametrize("kind", ["off", "ply"])
def test_indices_out_of_range(kind: str, index: float, refused: Callable[..., str]):
    data = ply(3, 1, TRIANGLE) if kind == "ply" else b"OFF\n3 1 0\n" + TRIANGLE
    text = refused(f"a.{kind}", data + f"3 0 1 {index}\n".encode(), GeometryError)
    assert "vertex" in text


def test_index_out_of_range_in_binary(refused: Callable[..., str]):
    face = struct.pack("<I3i", 3, 0, 1, 3)
    text = refused(
        "a.ply", ply(3, 1, PACKED_TRIANGLE + face, "binary_little_endian"), GeometryError
    )
    assert text == "a face names vertex 3, but the vertices are 0 … 2"


@pytest.mark.parametrize("index", [0, 4, -4])
def test_obj_counts_from_one(index: int, refused: Callable[..., str]):
    refused("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + f"f 1 2 {index}\n".encode(), GeometryError)


def test_vertices_that_are_not_finite(refused: Callable[..., str]):
    text = refused("a.off", b"OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", GeometryError)
    assert "1 of 3 vertices are NaN" in text


def test_too_large_coordinates(refused: Callable[..., str]):
    assert "check the file or its unit" in refused("a.xyz", b"1 2 3\n1e300 0 0\n", GeometryError)


@pytest.mark.parametrize("corner", ["0 0 0", "1 1 1"])
def test_many_faces_without_area(corner: str, refused: Callable[..., str]):
    """2 MB of triangles, each along a line or in a point."""
    vertices = ("0 0 0\n2 2 2\n" + corner + "\n") * 40_000
    faces = "".join(f"3 {i} {i + 1} {i + 2}\n" for i in range(0, 120_000, 3))
    data = f"OFF\n120000 40000 0\n{vertices}{faces}".encode()
    assert len(data) > 1.3e6
    assert "no area" in refused("a.off", data, GeometryError)


def test_no_faces(tmp_path: Path):
    (tmp_path / "a.off").write_bytes(b"OFF\n3 0 0\n" + TRIANGLE)
    with pytest.raises(GeometryError, match=r"a\.off: has no faces"):
        read_mesh(tmp_path / "a.off")
    # Faces of two corners are edges, not faces.
    (tmp_path / "a.off").write_bytes(b"OFF\n3 1 0\n" + TRIANGLE + b"2 0 1\n")
    with pytest.raises(GeometryError, match=r"a\.off: has no faces"):
        read_mesh(tmp_path / "a.off")


@pytest.mark.parametrize("name", ["a.off", "a.ply", "a.pcd", "a.npy", "a.npz"])
def test_no_points(name: str, refused: Callable[..., str]):
    data = {
        "a.off": b"OFF\n0 0 0\n",
        "a.ply": ply(0, 0),
        "a.pcd": shape_files.pcd_header("binary", 0),
        "a.npy": shape_files.npy(np.zeros((0, 3))),
        "a.npz": shape_files.saved(points=np.zeros((0, 3))),
    }[name]
    assert "no points" in refused(name, data, GeometryError)


def test_third_parties_are_silent(tmp_path: Path):
    """trimesh warns and logs about broken files; the user sees one line, from us."""
    data = shape_files.exported("glb")
    broken = [data[:-50], data[:200] + b"\xff" + data[201:], data[:30], b"glTF" + bytes(40)]
    program = (
        "import sys; from circumspect.geometry import read_cloud\n"
        "from circumspect.errors import InputError\n"
        "for path in sys.argv[1:]:\n"
        "    try: read_cloud(path, samples=3)\n"
        "    except InputError: pass\n"
    )
    for index, content in enumerate(broken):
        (tmp_path / f"{index}.glb").write_bytes(content)
    done = subprocess.run(
        [sys.executable, "-W", "always", "-c", program, *tmp_path.glob("*.glb")],
        capture_output=True,
        text=True,
        check=True,
    )
    assert (done.stdout, done.stderr) == ("", "")
