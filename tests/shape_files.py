"""Files of one small shape in every format, written by others where there is another writer."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable

import numpy as np
import trimesh
from numpy.typing import NDArray

# A box of 1 x 2 x 3 m, its corners in an order of its own, and its triangles.
BOX = trimesh.creation.box((1.0, 2.0, 3.0))
VERTICES = np.array(BOX.vertices, dtype=np.float64)
FACES = np.array(BOX.faces, dtype=np.int64)
AREA = 22.0
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
QUAD_VERTICES = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], dtype=float)
# A cloud whose numbers float32 holds exactly, and unit normals.
POINTS = np.random.default_rng(7).integers(-1000, 1000, (50, 3)) / 64.0
NORMALS = np.tile(np.eye(3), (17, 1))[:50]


def rows(table: NDArray[np.floating], separator: str = " ") -> str:
    """Lines of numbers, with all their digits."""
    return "".join(separator.join(map(repr, row)) + "\n" for row in table.tolist())


def exported(kind: str, **options: object) -> bytes:
    """The box, as trimesh writes it."""
    data = BOX.export(file_type=kind, **options)
    return data.encode() if isinstance(data, str) else bytes(data)


def off_quads() -> bytes:
    """A box of quadrilaterals with comments and colours."""
    faces = "".join(f"4 {' '.join(map(str, quad))} 255 0 0 # colour\n" for quad in QUADS)
    return f"# by hand\nOFF\n8 6 12\n\n{rows(QUAD_VERTICES)}{faces}".encode()


def off_malformed() -> bytes:
    """The first line as in some files of ModelNet."""
    return exported("off").replace(b"OFF\n", b"OFF", 1)


def obj_quads() -> bytes:
    """Quadrilaterals with textures, relative indices and a continued line."""
    vertices = "".join(f"v {line}\n" for line in rows(QUAD_VERTICES).splitlines())
    faces = "".join("f " + " ".join(f"{i + 1}/1/2" for i in quad) + "\n" for quad in QUADS[:4])
    relative = "".join("f " + " ".join(str(i - 8) for i in quad) + "\n" for quad in QUADS[4:])
    relative = relative.replace(" ", " \\\n ", 1)
    return f"mtllib none.mtl\no box\n{vertices}vt 0 0\nusemtl x\n{faces}s off\n{relative}".encode()


def ply_cloud(byte_order: str) -> bytes:
    """A cloud with normals and colours; `byte_order` is "<", ">" or "" for ASCII."""
    kind = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[byte_order]
    header = f"ply\nformat {kind} 1.0\ncomment by hand\nelement vertex {len(POINTS)}\n"
    header += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    header += "property uchar red\nend_header\n"
    if not byte_order:
        table = np.column_stack([POINTS, NORMALS, np.full(len(POINTS), 200)])
        return header.encode() + rows(table).encode()
    table = np.empty(
        len(POINTS), [("p", f"{byte_order}f4", 3), ("n", f"{byte_order}f4", 3), ("r", "u1")]
    )
    table["p"], table["n"], table["r"] = POINTS, NORMALS, 200
    return header.encode() + table.tobytes()


def ply_mixed(byte_order: str) -> bytes:
    """The box of five quadrilaterals and two triangles, with other elements and lists between."""
    kind = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[byte_order]
    header = (
        f"ply\r\nformat {kind} 1.0\r\nelement camera 1\r\nproperty double fx\r\n"
        "element vertex 8\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\n"
        "element face 7\r\nproperty uchar flag\r\nproperty list uchar int vertex_indices\r\n"
        "property list uchar float texcoord\r\nelement edge 0\r\nproperty int a\r\nend_header\r\n"
    ).encode()
    faces = [*QUADS[:5], QUADS[5][:3], [QUADS[5][0], QUADS[5][2], QUADS[5][3]]]
    if not byte_order:
        lines = "".join(f"1 {len(f)} {' '.join(map(str, f))} 2 0.5 0.5\n" for f in faces)
        return header + f"525.0\n{rows(QUAD_VERTICES)}{lines}".encode()
    body = struct.pack(f"{byte_order}d", 525.0)
    body += QUAD_VERTICES.astype(f"{byte_order}f8").tobytes()
    for face in faces:
        body += struct.pack(f"{byte_order}BB{len(face)}iB2f", 1, len(face), *face, 2, 0.5, 0.5)
    return header + body


def pcd_header(data: str, count: int = len(POINTS)) -> bytes:
    """x y z normals and padding."""
    return (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
        "FIELDS x y z _ normal_x normal_y normal_z label\nSIZE 4 4 4 1 4 4 4 4\n"
        f"TYPE F F F U F F F U\nCOUNT 1 1 1 4 1 1 1 1\nWIDTH {count}\nHEIGHT 1\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {data}\n"
    ).encode()


def pcd(data: str) -> bytes:
    """The cloud as ascii, binary or binary_compressed."""
    pad = np.zeros((len(POINTS), 4))
    label = np.arange(len(POINTS))[:, None]
    if data == "ascii":
        return pcd_header(data) + rows(np.hstack([POINTS, pad, NORMALS, label])).encode()
    if data == "binary":
        kind = [("p", "<f4", 3), ("_", "u1", 4), ("n", "<f4", 3), ("l", "<u4")]
        table = np.zeros(len(POINTS), kind)
        table["p"], table["n"], table["l"] = POINTS, NORMALS, label[:, 0]
        return pcd_header(data) + table.tobytes()
    columns = [*POINTS.T.astype("<f4"), pad.astype("u1"), *NORMALS.T.astype("<f4")]
    unpacked = b"".join(c.tobytes() for c in [*columns, label.astype("<u4")])
    packed = lzf_compressed(unpacked)
    return pcd_header(data) + struct.pack("<II", len(packed), len(unpacked)) + packed


def lzf_compressed(data: bytes) -> bytes:
    """Plain LZF: runs that repeat what stood within the last 8192 bytes, else literals."""
    packed, literal, seen, at = bytearray(), bytearray(), {}, 0

    def flush() -> None:
        for start in range(0, len(literal), 32):
            piece = literal[start : start + 32]
            packed.append(len(piece) - 1)
            packed.extend(piece)
        literal.clear()

    while at < len(data):
        key = data[at : at + 3]
        found = seen.get(key, -1)
        seen[key] = at
        if len(key) < 3 or found < 0 or at - found > 8192:
            literal.append(data[at])
            at += 1
            continue
        length = 3
        while (
            length < 264 and at + length < len(data) and data[found + length] == data[at + length]
        ):
            length += 1
        flush()
        offset = at - found - 1
        if length < 9:
            packed.append((length - 2) << 5 | offset >> 8)
        else:
            packed.extend([7 << 5 | offset >> 8, length - 9])
        packed.append(offset & 255)
        at += length
    flush()
    return bytes(packed)


def ptx(points: NDArray[np.floating], pose: str = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n") -> bytes:
    """A scan of one column, with intensities, behind its header."""
    header = f"1\n{len(points)}\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n{pose}"
    return (header + rows(np.column_stack([points, np.full(len(points), 0.5)]))).encode()


def saved(**arrays: NDArray[np.generic]) -> bytes:
    """An NPZ file."""
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=False, **arrays)
    return stream.getvalue()


def npy(array: NDArray[np.generic]) -> bytes:
    """An NPY file."""
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


MESHES: dict[str, Callable[[], bytes]] = {
    "plain.off": lambda: exported("off"),
    "malformed.off": off_malformed,
    "quads.off": off_quads,
    "binary.ply": lambda: exported("ply"),
    "ascii.ply": lambda: exported("ply", encoding="ascii"),
    "mixed_ascii.ply": lambda: ply_mixed(""),
    "mixed_little.ply": lambda: ply_mixed("<"),
    "mixed_big.ply": lambda: ply_mixed(">"),
    "binary.stl": lambda: exported("stl"),
    "ascii.stl": lambda: exported("stl_ascii"),
    "plain.obj": lambda: exported("obj"),
    "quads.obj": obj_quads,
    "binary.glb": lambda: exported("glb"),
}
CLOUDS: dict[str, Callable[[], bytes]] = {
    "ascii_cloud.ply": lambda: ply_cloud(""),
    "little_cloud.ply": lambda: ply_cloud("<"),
    "big_cloud.ply": lambda: ply_cloud(">"),
    "ascii.pcd": lambda: pcd("ascii"),
    "binary.pcd": lambda: pcd("binary"),
    "compressed.pcd": lambda: pcd("binary_compressed"),
    "cloud.obj": lambda: "".join(f"v {line}\n" for line in rows(POINTS).splitlines()).encode(),
    "plain.xyz": lambda: rows(POINTS).encode(),
    "title.txt": lambda: b"//X Y Z R G B\n50\n# c\n" + rows(np.hstack([POINTS, NORMALS])).encode(),
    "comma.csv": lambda: b"x,y,z\n" + rows(POINTS, ", ").encode(),
    "semicolon.txt": lambda: rows(POINTS, ";").encode(),
    "counts.pts": lambda: b"".join(
        f"{len(part)}\n".encode() + rows(np.hstack([part, part])).encode()
        for part in (POINTS[:20], POINTS[20:])
    ),
    "tabs.asc": lambda: rows(POINTS, "\t").encode(),
    "two_scans.ptx": lambda: ptx(POINTS[:20]) + ptx(POINTS[20:]),
    "named_wrongly.xyz": lambda: ptx(POINTS),
    "float32.npy": lambda: npy(np.hstack([POINTS, NORMALS]).astype(np.float32)),
    "columns.npy": lambda: npy(np.asfortranarray(POINTS)),
    "key.npz": lambda: saved(points=POINTS, other=np.zeros((4, 3))),
    "only.npz": lambda: saved(anything=POINTS, label=np.array(3)),
    "normals.npz": lambda: saved(points_xyz=POINTS, normals_xyz=NORMALS),
}
