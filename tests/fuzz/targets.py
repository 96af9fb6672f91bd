"""What is fuzzed: valid files by the project's own writers, and the reader that takes them."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

Seeds = Callable[[Path], list[Path]]
POINTS = np.random.default_rng(0).random((40, 3))


@dataclass(frozen=True)
class Target:
    """A reader and files that it reads.

    Attributes:
        seeds: Writes valid files into a folder.
        read: Reads one file, or raises a known fault.
        place: The name of the mutated file; None keeps the seed's.
    """

    seeds: Seeds
    read: Callable[[Path], object]
    place: str | None = None


def _shapes(folder: Path) -> list[Path]:
    rows = [" ".join(f"{value:.4f}" for value in row) for row in POINTS]
    faces = ["3 0 1 2", "3 1 2 3", "4 0 1 2 3"]
    texts = {
        "a.off": ["OFF", "40 3 0", *rows, *faces],
        "a.ply": [
            "ply", "format ascii 1.0", "element vertex 40", "property float x", "property float y",
            "property float z", "element face 3", "property list uchar int vertex_indices",
            "end_header", *rows, *faces,
        ],
        "a.obj": [*(f"v {row}" for row in rows), "f 1 2 3", "f -1 -2 -3"],
        "a.xyz": rows,
        "a.csv": ["x,y,z", *(row.replace(" ", ",") for row in rows)],
        "a.pcd": [
            "VERSION .7", "FIELDS x y z", "SIZE 4 4 4", "TYPE F F F", "COUNT 1 1 1", "WIDTH 40",
            "HEIGHT 1", "POINTS 40", "DATA ascii", *rows,
        ],
    }  # fmt: skip
    files = []
    for name, lines in texts.items():
        files.append(folder / name)
        files[-1].write_text("\n".join(lines) + "\n")
    triangle = struct.pack("<12fH", *[0.0] * 3, *POINTS[:3].ravel(), 0)
    (folder / "a.stl").write_bytes(bytes(80) + struct.pack("<I", 8) + 8 * triangle)
    head = b"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 40\nHEIGHT 1\n"
    binary = head + b"POINTS 40\nDATA binary\n" + POINTS.astype("<f4").tobytes()
    (folder / "b.pcd").write_bytes(binary)
    return [*files, folder / "a.stl", folder / "b.pcd", _gltf(folder)]


def _gltf(folder: Path) -> Path:
    data = POINTS.astype("<f4").tobytes()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "children": []}], "buffers": [{"byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 39, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    }  # fmt: skip
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<II", len(text), 0x4E4F534A) + text
    parts += struct.pack("<II", len(data), 0x004E4942) + data
    (folder / "a.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(parts)) + parts)
    return folder / "a.glb"


def _read_shape(path: Path) -> object:
    from circumspect.geometry import read_cloud

    return read_cloud(path, samples=100)


def _arrays(folder: Path) -> list[Path]:
    from circumspect.grid import CylindricalGrid, OccupancyGrid

    np.save(folder / "a.npy", POINTS)
    np.savez(folder / "a.npz", points_xyz=POINTS, normals_xyz=POINTS)
    np.savez_compressed(folder / "b.npz", cloud=POINTS, other=np.zeros(4))
    OccupancyGrid(CylindricalGrid((4, 8, 4)), np.zeros((4, 8, 4), np.uint8)).save(folder / "c.npz")
    return sorted(folder.iterdir())


def _read_array(path: Path) -> object:
    from circumspect.grid import OccupancyGrid
    from circumspect.grid.grid_file import holds_grid

    if path.suffix == ".npz" and holds_grid(path):
        return OccupancyGrid.load(path)
    return _read_shape(path)


def _recordings(folder: Path) -> list[Path]:
    from tests.fuzz.recorded import write_recordings

    return write_recordings(folder)


def _read_recording(path: Path) -> object:
    from circumspect.recording import open_recording

    recording = open_recording(path)
    return len(list(recording)), dict(recording.skipped)


def _pictures(folder: Path) -> list[Path]:
    from PIL import Image

    depth = (1000 * POINTS[:, :1] * np.ones((1, 30))).astype(np.uint16)
    Image.fromarray(depth).save(folder / "a.png")
    Image.fromarray((depth % 256).astype(np.uint8)).save(folder / "b.png")
    return [folder / "a.png", folder / "b.png"]


def _read_picture(path: Path) -> object:
    from circumspect.recording.frame_folder import read_colour, read_depth

    read_colour(path, (30, 40))
    return read_depth(path)


def _trajectories(folder: Path) -> list[Path]:
    lines = [f"{n}.5 {n} 0 0 0 0 0 1" for n in range(20)]
    (folder / "a.txt").write_text("# stamp\n" + "\n".join(lines) + "\n")
    return [folder / "a.txt"]


def _read_trajectory(path: Path) -> object:
    from circumspect.geometry import read_tum

    return read_tum(path)


def _manifests(folder: Path) -> list[Path]:
    from circumspect.datasets.gathered_set import MANIFEST, GatheredScan

    scans = [GatheredScan(f"a@{n:03}", "a", "chair", "train", 1.0 * n) for n in range(5)]
    (folder / MANIFEST).write_text("".join(scan.line() for scan in scans))
    return [folder / MANIFEST]


def _read_manifest(path: Path) -> object:
    from circumspect.datasets.gathered_set import read_manifest

    return read_manifest(path.parent)


def _checkpoints(folder: Path) -> list[Path]:
    from circumspect.classification import GridSpec
    from circumspect.nets import Checkpoint, build_net

    input_spec = GridSpec()
    weights = build_net("planes", 2, input_spec).state_dict()
    Checkpoint("planes", ("a", "b"), input_spec, weights).save(folder / "a.safetensors")
    return [folder / "a.safetensors"]


def _read_checkpoint(path: Path) -> object:
    from circumspect.nets import Checkpoint

    return Checkpoint.load(path).build()


def _networks(folder: Path) -> list[Path]:
    from circumspect.classification.onnx_session import shipped_network

    (folder / "a.onnx").write_bytes(shipped_network("modelnet10"))
    return [folder / "a.onnx"]


def _read_network(path: Path) -> object:
    from circumspect.classification import Classifier

    return Classifier.load(path).classes


TARGETS = {
    "shapes": Target(_shapes, _read_shape),
    "arrays": Target(_arrays, _read_array),
    "recordings": Target(_recordings, _read_recording),
    "pictures": Target(_pictures, _read_picture),
    "trajectories": Target(_trajectories, _read_trajectory),
    "manifests": Target(_manifests, _read_manifest, "manifest.jsonl"),
    "checkpoints": Target(_checkpoints, _read_checkpoint),
    "networks": Target(_networks, _read_network),
}
