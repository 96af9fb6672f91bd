"""Readers require only what they use, and say what they can not read."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shape_files
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.geometry import read_cloud, read_mesh

POINTS = shape_files.POINTS
ORDERS = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}


@pytest.fixture
def write_file(tmp_path: Path) -> Callable[[str, bytes], Path]:
    def write(name: str, data: bytes) -> Path:
        (tmp_path / name).write_bytes(data)
        return tmp_path / name

    return write


def ply_with_lists(order: str, lengths: list[int]) -> bytes:
    """A cloud whose vertices have a list between their coordinates and their normals."""
    header = (
        f"ply\nformat {ORDERS[order]} 1.0\nelement vertex {len(POINTS)}\nproperty float x\n"
        "property float y\nproperty float z\nproperty list uchar uint view_indices\n"
        "property float nx\nproperty float ny\nproperty float nz\nend_header\n"
    ).encode()
    rows = zip(POINTS.tolist(), lengths, shape_files.NORMALS.tolist(), strict=True)
    body = b""
    for point, length, normal in rows:
        views = range(length)
        if order:
            body += struct.pack(f"{order}3fB{length}I3f", *point, length, *views, *normal)
        else:
            body += (" ".join(map(repr, [*point, length, *views, *normal])) + "\n").encode()
    return header + body


@pytest.mark.parametrize("order", ORDERS)
@given(lengths=st.one_of(
    st.lists(st.integers(0, 5), min_size=50, max_size=50),
    st.integers(0, 5).map(lambda length: [length] * 50),
))  # fmt: skip
@settings(max_examples=15)
def test_lists_of_ply_vertices_are_skipped(
    order: str, lengths: list[int], tmp_path_factory: pytest.TempPathFactory
):
    path = tmp_path_factory.mktemp("ply") / "a.ply"
    path.write_bytes(ply_with_lists(order, lengths))
    cloud = read_cloud(path)
    np.testing.assert_array_equal(cloud.points_xyz, POINTS)
    np.testing.assert_array_equal(cloud.normals_xyz, shape_files.NORMALS)


@pytest.mark.parametrize("order", ["<", ">"])
def test_truncated_rows_with_lists_are_refused(
    order: str, write_file: Callable[[str, bytes], Path]
):
    for lengths in ([3] * 50, [3, 1] * 25):
        data = ply_with_lists(order, lengths)
        with pytest.raises(InputError, match="ends too early: 50 rows of 'vertex' announced"):
            read_cloud(write_file("a.ply", data[:-5]))


@pytest.mark.parametrize("order", ORDERS)
def test_ply_triangle_strips_are_triangles(order: str, write_file: Callable[[str, bytes], Path]):
    """Two sides of the box, in one list with a restart, and once more in a list of their own."""
    strips = [[0, 1, 2, 3, -1, 4, 6, 5, 7], [0, 1, 4, 5]]
    header = (
        f"ply\nformat {ORDERS[order]} 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nelement tristrips 2\nproperty list int int vertex_indices\nend_header\n"
    ).encode()
    if order:
        body = shape_files.QUAD_VERTICES.astype(f"{order}f4").tobytes()
        for strip in strips:
            body += struct.pack(f"{order}i{len(strip)}i", len(strip), *strip)
    else:
        body = shape_files.rows(shape_files.QUAD_VERTICES).encode()
        body += "".join(f"{len(s)} {' '.join(map(str, s))}\n" for s in strips).encode()
    mesh = read_mesh(write_file("a.ply", header + body))
    assert len(mesh.faces) == 6
    assert mesh.areas.sum() == pytest.approx(2 * 6.0 + 3.0)
    whole = header + body
    broken = whole.replace(b"0 1 4 5", b"0 1 4 9")
    if order:
        broken = whole[:-4] + struct.pack(f"{order}i", 9)
    path = write_file("b.ply", broken)
    with pytest.raises(InputError, match="a face names vertex 9"):
        read_mesh(path)


@pytest.mark.parametrize("order", ORDERS)
def test_a_ply_property_may_stand_twice_where_it_is_not_used(
    order: str, write_file: Callable[[str, bytes], Path]
):
    header = (
        f"ply\nformat {ORDERS[order]} 1.0\nelement vertex {len(POINTS)}\nproperty float x\n"
        "property float y\nproperty float z\nproperty float quality\nproperty float quality\n"
        "end_header\n"
    )
    table = np.column_stack([POINTS, POINTS[:, :2]])
    body = table.astype(f"{order}f4").tobytes() if order else shape_files.rows(table).encode()
    cloud = read_cloud(write_file("a.ply", header.encode() + body))
    np.testing.assert_array_equal(cloud.points_xyz, POINTS)
    with pytest.raises(InputError, match="'x' stands twice"):
        read_cloud(write_file("b.ply", header.replace("quality", "x").encode() + body))


def pcd(fields: str, data: str, body: bytes, more: str = "") -> bytes:
    count = len(fields.split())
    header = f"VERSION .7\nFIELDS {fields}\n{more}COUNT {'1 ' * count}\nWIDTH 50\nHEIGHT 1\nPOINTS 50\nDATA {data}\n"
    return header.encode() + body


SIZES = "SIZE 4 4 4 4 4\nTYPE F F F F F\n"


@pytest.mark.parametrize("data", ["ascii", "binary"])
def test_a_pcd_field_may_stand_twice_where_it_is_not_used(
    data: str, write_file: Callable[[str, bytes], Path]
):
    table = np.column_stack([POINTS, POINTS[:, :2]])
    body = table.astype("<f4").tobytes() if data == "binary" else shape_files.rows(table).encode()
    path = write_file("a.pcd", pcd("x y z intensity intensity", data, body, SIZES))
    np.testing.assert_array_equal(read_cloud(path).points_xyz, POINTS)
    with pytest.raises(InputError, match="'z' stands twice"):
        read_cloud(write_file("b.pcd", pcd("x y z z intensity", data, body, SIZES)))


def test_pcd_in_text_needs_no_types(write_file: Callable[[str, bytes], Path]):
    path = write_file("a.pcd", pcd("x y z", "ascii", shape_files.rows(POINTS).encode()))
    np.testing.assert_array_equal(read_cloud(path).points_xyz, POINTS)
    with pytest.raises(InputError, match="broken header"):
        read_cloud(write_file("b.pcd", pcd("x y z", "binary", POINTS.astype("<f4").tobytes())))


def test_stored_data_of_a_compressed_pcd_are_read(write_file: Callable[[str, bytes], Path]):
    body = POINTS.T.astype("<f4").tobytes()
    sizes = struct.pack("<II", len(body), len(body))
    more = "SIZE 4 4 4\nTYPE F F F\n"
    path = write_file("a.pcd", pcd("x y z", "binary_compressed", sizes + body, more))
    np.testing.assert_array_equal(read_cloud(path).points_xyz, POINTS)


@pytest.mark.parametrize("suffix", ["pcd", "npy", "xyz", "ply"])
def test_holes_at_the_origin_are_no_points(
    suffix: str, write_file: Callable[[str, bytes], Path], monkeypatch: pytest.MonkeyPatch, caplog
):
    points = POINTS.copy()
    points[::3] = 0
    monkeypatch.setattr(shape_files, "POINTS", points)
    name = {"pcd": "binary.pcd", "npy": "columns.npy", "xyz": "plain.xyz", "ply": "big_cloud.ply"}
    cloud = read_cloud(write_file(f"a.{suffix}", shape_files.CLOUDS[name[suffix]]()))
    np.testing.assert_array_equal(cloud.points_xyz, points[np.arange(50) % 3 > 0])
    assert "ignored 17 of 50 points at (0, 0, 0): no measurement" in caplog.text


def test_a_few_points_at_the_origin_are_kept(write_file: Callable[[str, bytes], Path]):
    points = np.concatenate([np.zeros((3, 3)), POINTS])
    assert len(read_cloud(write_file("a.npy", shape_files.npy(points)))) == 53
    # There is nothing else: not a scan with holes.
    assert len(read_cloud(write_file("a.npy", shape_files.npy(np.zeros((50, 3)))))) == 50


def test_unreferenced_vertices_may_be_missing(write_file: Callable[[str, bytes], Path], caplog):
    data = b"OFF\n5 1 0\nnan nan nan\n0 0 0\n1 0 0\nnan 0 0\n0 1 0\n3 1 2 4\n"
    assert read_mesh(write_file("a.off", data)).areas.sum() == pytest.approx(0.5)
    assert "ignored 2 vertices" in caplog.text


def free_format(header: bytes = b"OFF") -> bytes:
    """The box with all numbers in one line."""
    numbers = [
        *shape_files.QUAD_VERTICES.reshape(-1),
        *(n for q in shape_files.QUADS for n in [4, *q]),
    ]
    return header + b" 8 6 12 " + " ".join(f"{number:g}" for number in numbers).encode()


@pytest.mark.parametrize("width", [1, 5, 10_000])
def test_off_needs_no_line_breaks(width: int, write_file: Callable[[str, bytes], Path]):
    words = free_format().split()
    lines = [b" ".join(words[at : at + width]) for at in range(0, len(words), width)]
    mesh = read_mesh(write_file("a.off", b"\n".join(lines) + b"\n"))
    assert mesh.areas.sum() == pytest.approx(shape_files.AREA)


def test_off_in_free_format_still_has_to_fit_its_counts(write_file: Callable[[str, bytes], Path]):
    for data in (
        free_format()[:-2],
        free_format() + b" 1 2",
        free_format().replace(b" 4 ", b" nan "),
        free_format().replace(b" 4 ", b" 1e999 "),
        free_format().replace(b" 8 ", b" 9 ", 1),
    ):
        with pytest.raises(InputError, match=r"a\.off: "):
            read_mesh(write_file("a.off", data))


def test_homogeneous_off_is_divided(write_file: Callable[[str, bytes], Path]):
    for header, extra in ((b"4OFF", ""), (b"N4OFF", " 0 0 1"), (b"CN4OFF", " 0 0 1 1 0 0 1")):
        rows = "".join(
            " ".join(map(str, [*(2 * v).tolist(), 2.0])) + extra + "\n"
            for v in shape_files.QUAD_VERTICES
        )
        faces = "".join(f"4 {' '.join(map(str, q))}\n" for q in shape_files.QUADS)
        mesh = read_mesh(write_file("a.off", header + f"\n8 6 0\n{rows}{faces}".encode()))
        assert mesh.areas.sum() == pytest.approx(shape_files.AREA)


STL = shape_files.exported("stl_ascii")


@pytest.mark.parametrize(
    "data",
    [b" \r\n\t" + STL, STL.replace(b"endsolid", b"end solid"), STL.replace(b"endsolid", b"END SOLID"),
     b"solid x" + shape_files.exported("stl")[7:] + b"\0\0", b"solid\n" + STL[STL.index(b"facet"):]],
)  # fmt: skip
def test_stl_variants_of_other_programs(data: bytes, write_file: Callable[[str, bytes], Path]):
    assert read_mesh(write_file("a.stl", data)).areas.sum() == pytest.approx(shape_files.AREA)


def test_ptx_scans_stand_at_their_poses(write_file: Callable[[str, bytes], Path]):
    points = POINTS.copy()
    points[7] = 0
    pose = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n"
    cloud = read_cloud(write_file("a.ptx", shape_files.ptx(points, pose) + shape_files.ptx(POINTS)))
    x, y, z = np.delete(points, 7, axis=0).T
    expected = np.concatenate([np.stack([10 - y, 20 + x, 30 + z], axis=1), POINTS])
    np.testing.assert_allclose(cloud.points_xyz, expected)


@pytest.mark.parametrize(
    "first", [np.zeros(50), np.full(50, 1.5e9), np.arange(50), 0.1 * np.arange(3, 53)]
)
def test_a_label_or_an_index_is_not_x(first: np.ndarray, write_file: Callable[[str, bytes], Path]):
    table = np.column_stack([first, POINTS])
    with pytest.raises(InputError, match="has 4 columns without titles, and the first one is"):
        read_cloud(
            write_file("a.txt", shape_files.rows(table.astype(np.float32).astype(float)).encode())
        )
    titled = write_file("b.txt", b"id x y z\n" + shape_files.rows(table).encode())
    np.testing.assert_array_equal(read_cloud(titled).points_xyz, POINTS)


def test_a_flat_object_of_three_columns_is_read(write_file: Callable[[str, bytes], Path]):
    flat = POINTS * [0, 1, 1]
    assert len(read_cloud(write_file("a.xyz", shape_files.rows(flat).encode()))) == 50
    titled = b"x y z red\n" + shape_files.rows(np.column_stack([flat, POINTS[:, 0]])).encode()
    assert len(read_cloud(write_file("b.xyz", titled))) == 50


def archive(*names: str) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as file:
        for name in names:
            file.writestr(name, b"content")
    return stream.getvalue()


@pytest.mark.parametrize("name", ["a.zip", "a.3mf", "a", "a.ply"])
@pytest.mark.parametrize(
    ("members", "message"),
    [
        (("chair.ply",), "is a ZIP archive of chair.ply; unpack it first"),
        (
            ("a.off", "b.off", "c.off", "d.off"),
            "of a.off, b.off, c.off and 1 more; unpack it first",
        ),
        (
            ("[Content_Types].xml", "3D/3dmodel.model"),
            "is a 3MF file, which is not read; export it",
        ),
        ((), "is not a ZIP|is a ZIP archive of nothing|unknown format"),
    ],
)
def test_archives_are_named_as_what_they_are(
    name: str, members: tuple[str, ...], message: str, write_file: Callable[[str, bytes], Path]
):
    with pytest.raises(InputError, match=message):
        read_cloud(
            write_file(name, archive(*members)) if members else write_file("a.zip", archive())
        )


def test_a_broken_archive_is_named(write_file: Callable[[str, bytes], Path]):
    with pytest.raises(InputError, match="is a broken ZIP archive"):
        read_cloud(write_file("a.zip", archive("chair.ply")[:30]))
